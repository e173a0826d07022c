// Stubs of the GPU functions for builds without CUDA.
#ifndef KNEAD_HAS_CUDA
#include <stdexcept>

#include "host/base/machine.h"
#include "host/solver/editable_simulator.h"
#include "host/solver/gpu/material.h"
#include "host/solver/gpu/region_padding.h"
#include "host/solver/gpu/stages.h"

namespace knead {
namespace {

[[noreturn]] void refuse()
{
    throw std::runtime_error("no CUDA device: this build has no CUDA side");
}

}  // namespace

bool gpu_present() { return false; }
long gpu_waits() { return 0; }
std::string gpu_bus() { return ""; }
std::unique_ptr<EditableSimulator> gpu_solver(const Setup&, int) { refuse(); }
std::unique_ptr<EditableSimulator> gpu_solver(const Setup&, int, RegionPadding) { refuse(); }

std::vector<Functions<float>> gpu_functions(const std::vector<float>&) { refuse(); }
std::vector<Answers<float>> gpu_answers(const std::vector<Particle<float>>&,
                                        const std::vector<Material<float>>&, float)
{
    refuse();
}

struct GpuStages::State {};
GpuStages::GpuStages(const Setup&, const Motion&, double) { refuse(); }
GpuStages::~GpuStages() = default;
std::vector<int> GpuStages::sort() { refuse(); }
std::vector<Particle<double>> GpuStages::particles() { refuse(); }
std::vector<Node<float>> GpuStages::p2g() { refuse(); }
std::vector<Node<float>> GpuStages::grid(const std::vector<Node<float>>&) { refuse(); }
std::vector<Particle<double>> GpuStages::g2p(const std::vector<Node<float>>&) { refuse(); }
std::vector<Mask> GpuStages::masks() { refuse(); }
std::vector<int> GpuStages::lined_up() { refuse(); }

}  // namespace knead
#endif
