// Particles to files and back: binary PLY (".ply") that any point-cloud viewer opens and that loses
// nothing, or text (".csv").
#pragma once
#include <string>
#include <vector>

#include "cuda/mpm/particle.h"
#include "host/files/ply.h"

namespace knead {

// Throws InputError for another ending, OutputError where the file cannot be written.
void write_particles(const std::string& path, const std::vector<Particle<double>>& particles);

// By the ending, ".csv" or PLY. Needs x, y and z; what else is missing is 0. Throws InputError,
// also for non-finite numbers.
std::vector<Particle<double>> read_particles(const std::string& path);
std::vector<Particle<double>> to_particles(const PlyFile& ply, const std::string& path);
// A table with a heading: names, then rows of as many numbers, with commas between them.
std::vector<Particle<double>> parse_csv(const std::string& text, const std::string& path);
bool holds_particles(const PlyFile& ply);  // points with no faces; its header is enough

}  // namespace knead
