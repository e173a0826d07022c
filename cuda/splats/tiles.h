// Tiles of the screen, and the lists of splats that reach them. Eight thread blocks blend a tile,
// one part each. A list *by parts* has a splat once for each part that it reaches, and each block
// reads its own part's; a *whole* list has it once, and all eight blocks search it for splats that
// reach their part.
#pragma once
#include "cuda/math/hd.h"
#include "cuda/math/vec.h"
#include "cuda/splats/footprint.h"
#include "cuda/splats/fovea.h"

namespace knead {

constexpr int tile_size = 64;                     // pixels a side
constexpr int part_width = 32, part_height = 16;  // of a part [pixels]
constexpr int parts_across = tile_size / part_width;
constexpr int parts = parts_across * (tile_size / part_height);  // of a tile
constexpr int square_size = 16;  // granularity of hidden areas [pixels a side]

// The pixels of a part, relative to its tile's first. If a sample covers step x step pixels, a part
// still has its full number of samples, or those left in the tile; surplus parts are empty.
struct PartBox {
    int x, y, width, height;
};
HD PartBox part_box(int n, int step)
{
    const int x = n % parts_across * part_width * step, y = n / parts_across * part_height * step;
    return {x, y, clamp(tile_size - x, 0, part_width * step),
            clamp(tile_size - y, 0, part_height * step)};
}

// Whether a splat reaches a sample of part b of the tile whose first pixel is (x, y).
HD bool reaches_part(const Footprint<float>& f, int x, int y, const PartBox& b, int step)
{
    const float x0 = float(x + b.x) + sample_offset(step),
                y0 = float(y + b.y) + sample_offset(step);
    return reaches(f, x0, y0, x0 + float(b.width - step), y0 + float(b.height - step));
}

// The parts to draw, as bits, at sample step `step`, from those `seen` at step 1.
HD unsigned drawn_parts(unsigned seen, int step)
{
    if (step == 1) return seen;
    if (step == 4) return seen != 0;
    constexpr unsigned upper = (1u << parts / 2) - 1;
    return unsigned((seen & upper) != 0) | unsigned((seen & ~upper) != 0) << parts_across;
}

// One of this many candidates is sampled to estimate the length of a tile's list.
constexpr int sampling = 32;
// Cost of an additional list entry, in units of a block's test of an entry that does not reach its
// part: on an H200 listing takes about 40 ps, a test 5 to 10 ps.
constexpr int tests_per_entry = 6;
// Maximum length of a whole list, which every block searches: 64 batches of 128 entries, half a
// microsecond per batch if none of its splats reaches the block's part.
constexpr int longest_whole = 8192;

// Longer lists by parts are split over more blocks: one block needs some 5 us per batch if its
// splats are small and lie in the rows of few of its warps.
constexpr int max_list_per_block = 2048;

// Whether a whole list is cheaper for a tile than lists by parts. `splats`: number of sampled
// candidates that reach the tile; `entries`: their entries in a list by parts; `blocks`: number of
// parts that are drawn. False without samples: lists by parts contain no splat that is not drawn.
HD bool prefer_whole_list(unsigned splats, unsigned entries, int blocks)
{
    const long long more = (long long)entries - splats;  // additional entries if listed by parts
    const long long tests = (long long)blocks * splats - entries;
    return splats > 0 && splats <= longest_whole / sampling && more * tests_per_entry > tests;
}

}  // namespace knead
