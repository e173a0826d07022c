#include "render/tool_primitives.h"

#include "cuda/contact/skinning.h"

namespace knead {

std::vector<DrawPrimitive> draw_primitives(const Rig& rig, const Motion& motion, int tool)
{
    std::vector<DrawPrimitive> primitives;
    if (motion.to.empty()) return primitives;
    const Stretch<float> stretch = motion.stretch_of(std::size_t(tool));
    const auto pose = [&](int j) {
        const Joint<double>& at = motion.to[std::size_t(j)];
        return Joint<float>{cast<float>(at.q), cast<float>(at.p)};
    };
    for (const Primitive& p : rig.primitives) {
        if (p.tool != tool) continue;
        DrawPrimitive primitive{};
        primitive.count = p.count;
        for (int k = 0; k < 3; ++k) {
            const Binding<float> b = stretched(rig.spheres[std::size_t(p.sphere[k])], stretch);
            primitive.sphere[k] = {centre(b, pose), {}, {}, b.radius, 0};
        }
        primitives.push_back(primitive);
    }
    return primitives;
}

}  // namespace knead
