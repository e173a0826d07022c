// Deepest contacts of a warp's points, computed by its lanes together; same result as
// deepest_contact(). A closest point takes hundreds of instructions, and candidates differ from
// lane to lane: if each lane computed its own, the warp would execute those of all lanes, with a
// memory access for each. Instead the lanes first test one primitive each against the bounding box
// of all points; load a few of those that meet it into shared memory; list the pairs of these and
// the points that may be inside; and compute one closest point of that list per lane.
#pragma once
#include <type_traits>

#include "cuda/contact/contact.h"

namespace knead::gpu {

// Shared memory of a warp with `points` points. Labels need points < 32.
template <int points>
struct ContactSpace {
    static constexpr int slots = points == 32 ? 8 : 12;  // primitives loaded at a time
    using Listed = std::conditional_t<points == 32, unsigned char, unsigned short>;
    // A slot's shape and the beginning of its primitive, which is needed next. 17 rows: lanes that
    // read the same row of different slots access different banks.
    float4 shapes[slots][17];
    float4 normals[points];               // of the deepest contact, and its first weight
    float2 weights[points];               // its other weights
    unsigned long long deepest[points];   // bits of the depth; the primitive's complement
    Listed near[max_primitives];          // in order: a label << 8 | primitive
    unsigned char pairs[slots * points];  // points * slot + point
};

// Loads a block's mask by two vector loads instead of eight scalar ones.
__device__ inline Mask loaded(const Mask& mask)
{
    Mask all;
    UNROLL
    for (int k = 0; k < mask_words / 4; ++k)
        reinterpret_cast<uint4*>(all.bits)[k] = reinterpret_cast<const uint4*>(mask.bits)[k];
    return all;
}

// Minimum over a warp's lanes with `in`; NaN if there are none.
__device__ inline float min_of(float x, bool in)
{
    // Integers ordered like the floats: negative ones have all bits but the sign inverted.
    const auto turned = [](int bits) { return bits ^ (bits >> 31 & 0x7fffffff); };
    const int key = in ? turned(__float_as_int(x)) : 0x7fffffff;
    return __int_as_float(turned(__reduce_min_sync(0xffffffffu, key)));
}

// All functions are warp-collective. Lane l has point l % points; points is a power of two, at most
// 32. Points with `in` must be finite. `brief`: small numbers of points take a shorter path, which
// needs registers.
template <int points, bool brief = true>
class WarpContact {
  public:
    // `grown`: added to the radii of the primitives [m].
    __device__ WarpContact(ContactSpace<points>& space, const Colliders<float>& colliders,
                           float grown = 0)
        : s(space), c(colliders), grown(grown)
    {
    }

    // Lists the mask's primitives that may be near the points, each with the byte label(primitive);
    // a negative label excludes it. Returns their number.
    template <class Label>
    __device__ int find_near(const Mask& mask, bool in, Vec3<float> p, Label&& label)
    {
        const Vec3<float> low = {min_of(p.x, in), min_of(p.y, in), min_of(p.z, in)};
        const Vec3<float> high = {-min_of(-p.x, in), -min_of(-p.y, in), -min_of(-p.z, in)};
        __syncwarp();  // the previous list has been read
        int count = 0;
        for (int word = 0; 32 * word < c.shapes.count; word += 2) {
            int labels[2];
            UNROLL
            for (int k = 0; k < 2; ++k) {
                const unsigned queried = __reduce_or_sync(all, in ? mask.bits[word + k] : 0);
                const int own = 32 * (word + k) + lane;
                labels[k] = -1;
                if (!(queried >> lane & 1)) continue;
                const int given = label(own);
                if (met(c.shapes[own], low, high)) labels[k] = given;
            }
            UNROLL
            for (int k = 0; k < 2; ++k) {
                const unsigned lanes = __ballot_sync(all, labels[k] >= 0);
                if (labels[k] >= 0)
                    s.near[count + before(lanes)] =
                        static_cast<Listed>(labels[k] << 8 | (32 * (word + k) + lane));
                count += __popc(lanes);
            }
        }
        __syncwarp();
        return count;
    }

    // End of the run of equal labels that begins at `from`, among `count` listed.
    __device__ int run_end(int from, int count) const
    {
        const int label = s.near[from] >> 8;
        for (int k = from; k < count; k += 32) {
            const unsigned others =
                __ballot_sync(all, k + lane < count && s.near[k + lane] >> 8 != label);
            if (others) return k + lowest_bit(others);
        }
        return count;
    }
    __device__ int label(int k) const { return s.near[k] >> 8; }

    // deepest_contact() of the lane's point, among the primitives listed in [from, to).
    __device__ Contact<float> deepest(int from, int to, bool in, Vec3<float> p)
    {
        if (lane < points) s.deepest[lane] = 0;
        for (int k = from; k < to; k += slots) {
            const int count = min(to - k, slots);
            bring(k, count);
            const int pairs = pair(count, in, p);
            for (int first = 0; first < pairs; first += 32) descend(k, first, pairs, p);
            __syncwarp();
        }
        const unsigned long long found = s.deepest[point];
        if (found == 0) return {1e30f, {0, 1, 0}, {0, 0, 0}, -1};
        const float4 n = s.normals[point];
        const float2 l = s.weights[point];
        const ClosestPoint<float> f = {
            -__uint_as_float(unsigned(found >> 32)), {n.x, n.y, n.z}, n.w, l.x, l.y};
        const Primitive& q = c.primitives[int(~unsigned(found))];
        return {f.phi, f.n, surface_velocity(c, q, f), q.tool};
    }

  private:
    static constexpr unsigned all = 0xffffffffu;
    using Listed = typename ContactSpace<points>::Listed;
    static constexpr int slots = ContactSpace<points>::slots, parts = 32 / points;
    ContactSpace<points>& s;
    const Colliders<float>& c;
    const float grown;
    const int lane = int(threadIdx.x & 31), point = lane % points;

    // Number of set lanes below this one.
    __device__ static int before(unsigned lanes)
    {
        unsigned mask;
        asm("mov.u32 %0, %%lanemask_lt;" : "=r"(mask));
        return __popc(lanes & mask);
    }

    __device__ bool met(const Shape<float>& shape, Vec3<float> low, Vec3<float> high) const
    {
        return (shape.low.x - grown <= high.x) & (shape.low.y - grown <= high.y) &
               (shape.low.z - grown <= high.z) & (shape.high.x + grown >= low.x) &
               (shape.high.y + grown >= low.y) & (shape.high.z + grown >= low.z);
    }

    // Index of the k-th listed primitive.
    __device__ int primitive(int k) const { return s.near[k] & 255; }

    __device__ const Shape<float>& shape(int slot) const
    {
        return reinterpret_cast<const Shape<float>&>(s.shapes[slot]);
    }

    // Loads the listed primitives from the k-th on into the slots.
    __device__ void bring(int k, int count)
    {
        static_assert(sizeof(Shape<float>) == 16 * 16 && sizeof(Primitive) == 32);
        constexpr int together = brief ? 6 : 2;  // limited by registers
        const int half = lane >> 4, row = lane & 15;
        float4 ends{};
        if (lane < count)
            ends = *reinterpret_cast<const float4*>(&c.primitives[primitive(k + lane)]);
        UNROLL
        for (int first = 0; first < slots; first += together) {
            float4 rows[together / 2];
            UNROLL
            for (int r = 0; r < together / 2; ++r)
                if (first + 2 * r + half < count)
                    rows[r] = reinterpret_cast<const float4*>(
                        &c.shapes[primitive(k + first + 2 * r + half)])[row];
            UNROLL
            for (int r = 0; r < together / 2; ++r)
                if (first + 2 * r + half < count) s.shapes[first + 2 * r + half][row] = rows[r];
            if (first + together >= count) break;
        }
        if (lane < count) s.shapes[lane][16] = ends;
        __syncwarp();
    }

    // Lists the pairs of a point and a slot that may contain it; for few points, as in a second
    // pass, all pairs: the test costs as much as the closest point. Returns their number.
    __device__ int pair(int count, bool in, Vec3<float> p)
    {
        const unsigned queried = __ballot_sync(all, in && lane < points);
        const int few = __popc(queried);
        if (brief && count > 2 * parts && few * count <= 32) {
            unsigned char* to = s.pairs + before(queried);
            if (in && lane < points)
                for (int own = point; own < points * count; own += points, to += few)
                    *to = static_cast<unsigned char>(own);
            __syncwarp();
            return few * count;
        }
        int listed = 0;
        for (int k = lane / points; k < count + lane / points; k += 2 * parts) {
            bool may[2];
            UNROLL
            for (int r = 0; r < 2; ++r)
                may[r] = in && k + r * parts < count && enclosed(shape(k + r * parts), p, grown);
            UNROLL
            for (int r = 0; r < 2; ++r) {
                const unsigned lanes = __ballot_sync(all, may[r]);
                if (may[r])
                    s.pairs[listed + before(lanes)] =
                        static_cast<unsigned char>((k + r * parts) * points + point);
                listed += __popc(lanes);
            }
        }
        __syncwarp();
        return listed;
    }

    // The closest points of 32 pairs.
    __device__ void descend(int k, int first, int pairs, Vec3<float> p)
    {
        const bool valid = first + lane < pairs;
        const unsigned own = valid ? s.pairs[first + lane] : 0;
        const int slot = int(own / points), of = int(own % points);
        const Vec3<float> x = {__shfl_sync(all, p.x, of), __shfl_sync(all, p.y, of),
                               __shfl_sync(all, p.z, of)};
        ClosestPoint<float> f{};
        if (valid) f = closest_point(shape(slot), x), f.phi -= grown;
        unsigned long long key = 0;
        if (f.phi < 0) {
            key = static_cast<unsigned long long>(__float_as_uint(-f.phi)) << 32 |
                  unsigned(~primitive(k + slot));
            atomicMax(&s.deepest[of], key);
        }
        __syncwarp();
        if (key != 0 && s.deepest[of] == key) {
            s.normals[of] = {f.n.x, f.n.y, f.n.z, f.l0};
            s.weights[of] = {f.l1, f.l2};
        }
        __syncwarp();
    }
};

}  // namespace knead::gpu
