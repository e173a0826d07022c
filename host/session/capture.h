// Differences of clay between two steps of the history, as bytes. They are exact in both
// directions: the rows of either step give those of the other. docs/method/history.md.
//
//     head, 40 bytes: kind, counts of particles and Gaussians, hashes of the rows
//     quantised only: the steps of the numbers, and for which planes they hold
//     for each plane of 32-bit numbers: its lowest bytes, then the next, ..., each a frame of zstd
//     whole rows only: zeros, so that the bytes are at least 1/256 of the rows that they hold
//
// Floats are taken as integers in the same order; where all of a plane are multiples of its step,
// the quantised codec takes the multiples. A plane of a difference has how much each integer
// changes, less how much that of the particle before it changes: particles are neighbours in the
// order of their ids, and move alike. A plane of whole rows has each integer less the one before.
#pragma once
#include <cstdint>
#include <string>

#include "host/session/quantisation.h"

namespace knead {

// XXH3 of all numbers, and of how many there are.
std::uint64_t hash(const ClayRows& rows);
// Bytes of the rows in memory.
std::size_t bytes_of(const ClayRows& rows);

// Whole rows, compressed by zstd. With `steps`, those of quantised() rows take fewer bytes; any
// other rows come back to the bit as well.
std::string encoded(const ClayRows& rows, const Quantisation* steps = nullptr);
// Throws InputError for bytes that are not those of encoded(). Allocates nothing before the counts
// are checked against the bytes: at most 256 times as much.
ClayRows decoded(const std::string& bytes);

// Whether the rows of both have the same particles and Gaussians, of the same objects: only then
// there is a difference.
bool same_members(const ClayRows& a, const ClayRows& b);
// Compressed by zstd; `steps` as for encoded(). Throws std::invalid_argument without
// same_members().
std::string difference(const ClayRows& a, const ClayRows& b, const Quantisation* steps = nullptr);
// Makes the rows of the one step those of the other: a + difference(a, b) = b, b + difference(a, b)
// = a. Throws InputError for bytes that are not a difference of these rows from others; `rows` are
// then unchanged.
void apply_difference(ClayRows& rows, const std::string& bytes);

// Hash of the rows that encoded() rows have or a difference leads to, as their head says. Throws
// InputError if there is no head.
std::uint64_t hash_after(const std::string& bytes);

}  // namespace knead
