// The stages of a frame of splats on the device, in their order, and all that their kernels see.
//   project . sort . scan . emit . sort by tile . blend
// Splats are ordered by depth once for both eyes, then listed by the tiles that they reach: the
// tiles of the second eye follow those of the first, so that one stable sort by tile serves both.
// How a tile lists them, whole or by parts, is chosen by what was found in the frame before; pixels
// are the same to the bit either way.
// Every buffer has a fixed size, every count stays on the device, nothing waits for the host. Where
// the list is full, the farthest splats are left out of it, and counted.
#pragma once
#include <cuda_runtime.h>

#include <cstdint>

#include "cuda/math/span.h"
#include "cuda/splats/blend.h"
#include "cuda/splats/eye.h"
#include "cuda/splats/fovea.h"
#include "cuda/splats/tiles.h"

namespace knead::gpu {

constexpr int max_squares = 1 << 16;       // of both eyes
constexpr int max_tiles = 65536 / parts;   // keys of 16 bits; of so many squares there are 4866
static_assert(tile_size == fovea_square);  // so a tile has one step

// Splats as they are at rest.
struct SplatView {
    int count, degree;    // of the harmonics
    const float4* place;  // x, y, z [m], opacity
    const float4* turn;   // x, y, z, w
    const float4* scale;  // half axes [m], nothing
    const uint4* sh;      // sh_row(degree) each: halves, red, green and blue of every coefficient
};
// Of how many uint4 a splat's harmonics are.
HD constexpr int sh_row(int degree) { return (3 * harmonics(degree) + 7) / 8; }

// The first `count` splats, where they are in this frame. Both pointers step by so many floats.
struct MovedSplats {
    int count;
    const float* centre;  // x, y, z [m]
    int centre_stride;
    const float* F;  // the columns of the total deformation gradient
    int F_stride;
    // Where they were before, alike; null: they are drawn where they are. Else both go on from
    // there by so much more of the way.
    const float *centre_before = nullptr, *F_before = nullptr;
    float extrapolation = 0;
};

// Of one eye, rows from the top.
struct RasterTarget {
    const uint2* mesh_colour;  // four halves; null: none
    const float* mesh_depth;   // [m]; no_depth: no mesh here
    uint2* colour;             // four halves: red, green, blue, what splats and mesh cover
    float* depth;              // [m]: where half of what lies behind is hidden, or no_depth
};

// What changes from frame to frame; in device memory, so that a captured graph stays as it is.
struct RasterFrame {
    SplatView splats;  // as many as the view has places for, or fewer
    Pinhole<float> camera[2];
    Vec3<float> middle;  // of the eyes [m]
    SplatOptions<float> options;
    Vec3<float> background;
    MovedSplats moved;
    RasterTarget target[2];
    const char* hidden;  // RasterView::all_squares(): 1 where nothing is drawn; null: all is
    Fovea<float> fovea[2];
};

// The first tile, and how many columns and rows of tiles a splat may touch; no rows: not seen.
struct TileBox {
    std::uint16_t x, y, columns, rows;
};
struct alignas(16) TileBoxes {
    TileBox eye[2];
};

// What tile tests and blending read of a splat as an eye sees it.
struct alignas(32) SplatShape {
    float u, v, a, b, c, peak, red, green;
};
struct alignas(16) SplatRest {
    float blue, depth, gx, gy;
};

// Pairs of a tile and a splat whose box it meets are *candidates*; the entries of a tile's lists
// are *instances*: at most one of a candidate where the tile is listed whole, else at most one of
// each part. Candidates are looked at so many at a time, by one thread block.
constexpr int chunk_size = 2048;

// What was sampled of a tile: splats, and entries of a list by parts (best_whole()).
struct alignas(8) TileSample {
    unsigned splats, entries;
};

// How a tile is drawn in this frame: the parts of which something is, as bits, the step of its
// samples, and how it is listed.
struct alignas(4) TileOptions {
    unsigned char drawn, step;
    bool whole;
};

// How much there was of everything in the last frame.
struct RasterCounts {
    unsigned long long listed;     // instances in the list
    unsigned long long instances;  // all, and as many as there may be of candidates not looked at
    unsigned long long dropped;    // of these, what is not in the list
    unsigned visible;              // splats that an eye sees
    int next_chunk;                // of candidates
    int put_off;                   // parts with long lists
};

struct RasterView {
    int count, degree;  // of splats, or places for them; of their harmonics
    const RasterFrame* frame;
    int eyes, columns, rows;  // columns and rows of tiles of an eye: both are of one size
    int width, height;        // pixels of an eye

    // Per splat, in the order of memory.
    std::uint32_t* depth_keys;
    TileBoxes* boxes;
    SplatShape* shapes;  // eyes * count, those of one eye behind those of the other
    SplatRest* rests;
    // By depth.
    const int* numbers;  // 0, 1, 2, ...
    std::uint32_t* sorted_keys;
    int* order;
    unsigned long long* candidate_starts;  // count + 1
    // By chunks of candidates; more chunks are not looked at.
    int chunks;
    unsigned long long* chunk_states;
    // Instances, on two sides between which they are sorted; they begin and end on the first.
    int room;
    std::uint16_t* keys[2];                 // tile * parts + part; part 0 where listed whole
    int* records[2];                        // index of a shape
    unsigned *digit_counts, *digit_starts;  // digit_table_size each
    // Per key where its instances end, and how far from the end of the room they begin: 0 where
    // there are none.
    uint2* ranges;
    // Per tile.
    const unsigned char* seen_parts;  // a bit each: in the picture, and not all of it is hidden
    TileSample* samples;              // of this frame, from emit() on
    TileOptions* rules;               // from emit() on
    int* put_off;                     // keys of parts; room for all
    RasterCounts* counts;

    HD int tiles_of_eye() const { return columns * rows; }
    HD int all_tiles() const { return eyes * columns * rows; }
    HD int all_keys() const { return all_tiles() * parts; }
    HD int square_columns() const { return (width + square_size - 1) / square_size; }
    HD int square_rows() const { return (height + square_size - 1) / square_size; }
    HD int all_squares() const { return eyes * square_columns() * square_rows(); }
};

struct RasterScratch {
    void* memory;
    std::size_t bytes;
};
constexpr int digit_table_size = 256 * 396;
std::size_t raster_scratch_bytes(int splats);
std::size_t tile_sort_scratch_bytes();

// Puts the frame where the stages read it; by value, so that the caller's may go.
void set_frame(RasterFrame* to, const RasterFrame& frame, cudaStream_t stream);

// The stages. Every splat as each eye sees it; the first `moved` as the frame says.
void project(const RasterView& view, int moved, cudaStream_t stream);
// Nearest first.
void sort_by_depth(const RasterView& view, const RasterScratch& s, cudaStream_t stream);
// Where the candidates of each splat begin.
void scan_candidates(const RasterView& view, const RasterScratch& s, cudaStream_t stream);
// How each tile is listed, and the instances in the order of depth.
void emit(const RasterView& view, cudaStream_t stream);
// By tile and part, and where those of each lie.
void sort_by_tile(const RasterView& view, const RasterScratch& s, cudaStream_t stream);
// `mesh`: the targets have one.
void blend(const RasterView& view, bool mesh, cudaStream_t stream);

}  // namespace knead::gpu
