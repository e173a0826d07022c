// Particles inside tools after a frame: penetration depths and grid velocities.  (19)
#include "cuda/mpm/g2p.h"
#include "cuda/mpm/project.h"
#include "host/solver/cpu/solver.h"

namespace knead {
inline namespace KNEAD_CPU_LEVEL {

template <class R>
std::vector<double> CpuSolver<R>::penetration() const
{
    std::vector<double> depths;
    if (posed.masked.empty()) return depths;
    for (const Particle<R>& p : q) {
        const Contact<R> hit = deepest_contact(posed.colliders(), posed.mask_at(lattice, p.x), p.x);
        if (hit.phi < 0) depths.push_back(double(-hit.phi));
    }
    return depths;
}

template <class R>
std::vector<Vec3<double>> CpuSolver<R>::velocities() const
{
    if (posed.masked.empty() || scene.passes == 0) return {};
    std::vector<Vec3<double>> all(q.size());
    for (std::size_t i = 0; i < q.size(); ++i) {
        const Particle<R>& p = q[i];
        const Mask& mask = posed.mask_at(lattice, p.x);
        const bool in = deepest_contact(posed.colliders(), mask, p.x, pushout.skin).phi < 0;
        const auto node = [&](Int3 n) {
            const int at = lattice.index(n);
            return bins.reaches(at / block_nodes) ? grid[0][std::size_t(at)] : Node<R>{};
        };
        const Vec3<R> v = in ? velocity_at(p.x, lattice.dx, p.v, node) : p.v;
        all[std::size_t(ids[i])] = cast<double>(v);
    }
    return all;
}

template std::vector<double> CpuSolver<float>::penetration() const;
template std::vector<Vec3<double>> CpuSolver<float>::velocities() const;

}  // namespace KNEAD_CPU_LEVEL
}  // namespace knead
