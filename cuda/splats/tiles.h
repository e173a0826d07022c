// Tiles of a picture, and how each lists the splats that reach it. Eight thread blocks blend a
// tile, each a part. A list *by parts* has a splat once for each part that it reaches, and each
// block its own; a *whole* one has it once, and all eight blocks look through it for what reaches
// their part.
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
constexpr int square_size = 16;  // of what is hidden or not [pixels a side]

// The pixels of a part, counted from its tile's first: where one sample stands for step x step of
// them, a part has as many samples as ever, or those that are left of the tile; parts of the
// numbers that a tile then does not need have no pixels.
struct PartBox {
    int x, y, width, height;
};
HD PartBox part_box(int n, int step)
{
    const int x = n % parts_across * part_width * step, y = n / parts_across * part_height * step;
    return {x, y, clamp(tile_size - x, 0, part_width * step),
            clamp(tile_size - y, 0, part_height * step)};
}

// Whether a splat reaches a sample of a part of the tile whose first pixel is (x, y).
HD bool reaches_part(const Footprint<float>& f, int x, int y, const PartBox& b, int step)
{
    const float x0 = float(x + b.x) + sample_offset(step),
                y0 = float(y + b.y) + sample_offset(step);
    return reaches(f, x0, y0, x0 + float(b.width - step), y0 + float(b.height - step));
}

// Which parts are drawn, as bits, where samples have that step: of `seen`, those of step 1.
HD unsigned drawn_parts(unsigned seen, int step)
{
    if (step == 1) return seen;
    if (step == 4) return seen != 0;
    constexpr unsigned upper = (1u << parts / 2) - 1;
    return unsigned((seen & upper) != 0) | unsigned((seen & ~upper) != 0) << parts_across;
}

// One of so many candidates tells how long a tile's list is.
constexpr int sampling = 32;
// An entry more costs as much as so many looks of a block at one that does not reach its part:
// about 40 ps to list it, on an H200, against 5 to 10 for a look.
constexpr int looks_an_entry = 6;
// Whole lists have about so many splats at most, for a block looks through one alone: 64 batches of
// 128, of half a microsecond each where nothing in them reaches its part.
constexpr int longest_whole = 8192;

// Longer lists by parts are shared out among more blocks: one goes through a list alone, for some
// 5 us a batch where its splats are small and lie in the rows of few of its warps.
constexpr int longest_of_a_block = 2048;

// Whether a tile is best listed whole, of whose candidates those that were sampled are `splats`
// that reach it and `entries` of a list by parts; `blocks` of its parts are drawn. False where
// nothing is known: by parts no list is longer than what is drawn.
HD bool best_whole(unsigned splats, unsigned entries, int blocks)
{
    const long long more = (long long)entries - splats;  // if listed by parts
    const long long looks = (long long)blocks * splats - entries;
    return splats > 0 && splats <= longest_whole / sampling && more * looks_an_entry > looks;
}

}  // namespace knead
