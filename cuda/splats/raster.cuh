// The stages of a frame of splats on the device, in order, and the data of their kernels.
//   project . sort . scan . emit . sort by tile . blend
// Splats are sorted by depth once for both eyes, then listed by the tiles that they reach: the
// tiles of the second eye follow those of the first, so that one stable sort by tile serves both.
// Whether a tile's list is whole or by parts is chosen from samples of the previous frame; pixels
// are bitwise the same. All buffers have fixed sizes, all counts stay on the device, and nothing
// waits for the host. If the list is full, the farthest splats are dropped, and counted.
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
constexpr int max_tiles = 65536 / parts;   // 16-bit keys; this many squares have 4866 tiles
static_assert(tile_size == fovea_square);  // so a tile has one step

// Splats at rest.
struct SplatView {
    int count, degree;    // number of splats; degree of the harmonics
    const float4* place;  // x, y, z [m], opacity
    const float4* turn;   // x, y, z, w
    const float4* scale;  // half axes [m]; w is unused
    const uint4* sh;      // sh_row(degree) each: halves, red, green and blue of every coefficient
};
// Number of uint4 in a splat's harmonics.
HD constexpr int sh_row(int degree) { return (3 * harmonics(degree) + 7) / 8; }

// Positions of the first `count` splats in this frame. Strides are in floats.
struct MovedSplats {
    int count;
    const float* centre;  // x, y, z [m]
    int centre_stride;
    const float* F;  // the columns of the total deformation gradient
    int F_stride;
    // Positions and F of the previous frame; null: no extrapolation. Otherwise both are
    // extrapolated by this fraction of their change.
    const float *centre_before = nullptr, *F_before = nullptr;
    float extrapolation = 0;
};

// Images of one eye, rows from the top.
struct RasterTarget {
    const uint2* mesh_colour;  // four halves; null: none
    const float* mesh_depth;   // [m]; no_depth: no mesh here
    uint2* colour;             // four halves: red, green, blue, coverage of splats and mesh
    float* depth;              // depth at which the transmittance falls to 1/2 [m], or no_depth
};

// Parameters of a frame; in device memory, so that a captured graph need not change.
struct RasterFrame {
    SplatView splats;  // at most as many as the view has room for
    Pinhole<float> camera[2];
    Vec3<float> middle;  // midpoint between the eyes [m]
    SplatOptions<float> options;
    Vec3<float> background;
    MovedSplats moved;
    RasterTarget target[2];
    const char* hidden;  // RasterView::all_squares(): 1 where nothing is drawn; null: all is drawn
    Fovea<float> fovea[2];
};

// The first tile, and the columns and rows of tiles that a splat may touch; 0 rows: not visible.
struct TileBox {
    std::uint16_t x, y, columns, rows;
};
struct alignas(16) TileBoxes {
    TileBox eye[2];
};

// Data of a splat in an eye's view for tile tests and blending.
struct alignas(32) SplatShape {
    float u, v, a, b, c, peak, red, green;
};
struct alignas(16) SplatRest {
    float blue, depth, gx, gy;
};

// *Candidates* are pairs of a tile and a splat whose box overlaps it. *Instances* are the entries
// of a tile's lists: at most one per candidate if the tile is listed whole, else at most one per
// part. A thread block tests chunk_size candidates at a time.
constexpr int chunk_size = 2048;

// Samples of a tile: splats, and entries of a list by parts (prefer_whole_list()).
struct alignas(8) TileSample {
    unsigned splats, entries;
};

// How a tile is drawn in this frame: bits of its visible parts, the step of its samples, and the
// kind of its list.
struct alignas(4) TileOptions {
    unsigned char drawn, step;
    bool whole;
};

// Counts of the last frame.
struct RasterCounts {
    unsigned long long listed;     // instances in the list
    unsigned long long instances;  // all, including an upper bound for candidates not tested
    unsigned long long dropped;    // of these, not in the list
    unsigned visible;              // splats in any view
    int next_chunk;                // of candidates
    int deferred;                  // deferred parts, with long lists
};

struct RasterView {
    int count, degree;  // number of splats, or capacity; degree of the harmonics
    const RasterFrame* frame;
    int eyes, columns, rows;  // tiles per eye; both eyes have the same size
    int width, height;        // pixels of an eye

    // Per splat, in the order of memory.
    std::uint32_t* depth_keys;
    TileBoxes* boxes;
    SplatShape* shapes;  // eyes * count, first those of the first eye
    SplatRest* rests;
    // By depth.
    const int* numbers;  // 0, 1, 2, ...
    std::uint32_t* sorted_keys;
    int* order;
    unsigned long long* candidate_starts;  // count + 1
    // By chunks of candidates; chunks beyond `chunks` are not tested.
    int chunks;
    unsigned long long* chunk_states;
    // Instances, in two buffers for sorting; input and result are in the first.
    int room;
    std::uint16_t* keys[2];                 // tile * parts + part; part 0 where listed whole
    int* records[2];                        // index of a shape
    unsigned *digit_counts, *digit_starts;  // digit_table_size each
    // Per key the end of its instances, and the distance of their start from the end of the room: 0
    // if there are none.
    uint2* ranges;
    // Per tile.
    const unsigned char* seen_parts;  // one bit per part: on the screen, and not entirely hidden
    TileSample* samples;              // of this frame, from emit() on
    TileOptions* rules;               // from emit() on
    int* deferred;                    // keys of parts; room for all
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

// Copies the frame to where the stages read it; passed by value, so the caller's may be destroyed.
void set_frame(RasterFrame* to, const RasterFrame& frame, cudaStream_t stream);

// The stages. Projects every splat for each eye; the first `moved` at the frame's positions.
void project(const RasterView& view, int moved, cudaStream_t stream);
// Nearest first.
void sort_by_depth(const RasterView& view, const RasterScratch& s, cudaStream_t stream);
// The first candidate of each splat.
void scan_candidates(const RasterView& view, const RasterScratch& s, cudaStream_t stream);
// Chooses the kind of each tile's list, and lists the instances in order of depth.
void emit(const RasterView& view, cudaStream_t stream);
// Sorts by tile and part, and finds the range of each.
void sort_by_tile(const RasterView& view, const RasterScratch& s, cudaStream_t stream);
// `mesh`: the targets contain one.
void blend(const RasterView& view, bool mesh, cudaStream_t stream);

}  // namespace knead::gpu
