// Particle files: binary PLY (".ply"), lossless and readable by any point-cloud viewer, or text
// (".csv").
#pragma once
#include <string>
#include <vector>

#include "cuda/mpm/particle.h"
#include "host/files/ply.h"

namespace knead {

// Throws InputError for another extension, OutputError if writing fails.
void write_particles(const std::string& path, const std::vector<Particle<double>>& particles);

// Reads the format of the extension, ".csv" or PLY. Requires x, y and z; other missing properties
// are 0. Throws InputError, also for non-finite numbers.
std::vector<Particle<double>> read_particles(const std::string& path);
std::vector<Particle<double>> to_particles(const PlyFile& ply, const std::string& path);
// Parses a header line of names, then rows of as many numbers, separated by commas.
std::vector<Particle<double>> parse_csv(const std::string& text, const std::string& path);
bool holds_particles(const PlyFile& ply);  // points without faces; the header suffices

}  // namespace knead
