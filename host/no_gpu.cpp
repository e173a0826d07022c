// What stands for the device where the build has none.
#ifndef KNEAD_HAS_CUDA
#include <stdexcept>

#include "gpu_stages.h"
#include "solver.h"

namespace knead {
namespace {

[[noreturn]] void refuse()
{
    throw std::runtime_error("no CUDA device: this build has no CUDA side");
}

}  // namespace

bool gpu_present() { return false; }
std::unique_ptr<Solver> gpu_solver(const Setup&, int) { refuse(); }

struct GpuStages::Held {};
GpuStages::GpuStages(const Setup&, const Motion&, double) { refuse(); }
GpuStages::~GpuStages() = default;
void GpuStages::sort() { refuse(); }
std::vector<Node<float>> GpuStages::p2g() { refuse(); }
std::vector<Node<float>> GpuStages::grid(const std::vector<Node<float>>&) { refuse(); }
std::vector<Particle<double>> GpuStages::g2p(const std::vector<Node<float>>&) { refuse(); }
std::vector<Mask> GpuStages::masks() { refuse(); }

}  // namespace knead
#endif
