// Audit of a state of the clay: total mass, volume, momentum, energy, and a hash.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"
#include "host/solver/simulator.h"

namespace knead {

struct Audit {
    double mass = 0;                  // [kg]
    double volume = 0;                // sum of J times the volume at rest [m^3]
    double unloaded = 0;              // the same without the elastic part of J [m^3]
    Vec3<double> momentum{}, spin{};  // [kg m/s]; angular, about the origin [kg m^2/s]
    double kinetic = 0, elastic = 0;  // [J]; kinetic includes the affine velocity
    double fastest = 0;               // [m/s]
    long broken = 0;                  // particles with a non-finite number
    std::uint64_t hash = 0;           // xxh64 over all particles
};

// All sums in double, in particle order. `velocities`: from Simulator::velocities(); if empty,
// Particle::v is used.
Audit audit(const std::vector<Particle<double>>& particles,
            const std::vector<Material<double>>& materials, double dx,
            const std::vector<Vec3<double>>& velocities = {});

// Kinetic energy of an affine velocity [J]: sum_i w_ip m |C (x_i - x_p)|^2 / 2, and dx^2 / 4 is the
// second moment of the weights along an axis (1).  (8a)
double affine_energy(const Mat3<double>& C, double mass, double dx);

// Overlap of clay with itself. It does not appear in the volumes, because projection and walls move
// particles without changing their J.
struct Crowding {
    long particles = 0;  // at which the claimed volume exceeds `crowded` times the available
    double most = 0;     // largest ratio of claimed to available volume
};
constexpr double crowded = 1.3;
Crowding crowding(const std::vector<Particle<double>>& particles,
                  const std::vector<Material<double>>& materials, double dx);

// ln of the volume over the volume at rest, plastic part included [1].
double log_volume_ratio(const Particle<double>& q, const Material<double>& m);
// Elastic energy per volume at rest [J/m^3]: its derivative is the stress of material.h.
double stored_energy(const Particle<double>& q, const Material<double>& m);

std::string hexadecimal(std::uint64_t hash);

}  // namespace knead
