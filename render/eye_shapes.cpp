#include "render/eye_shapes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace knead {
std::vector<DrawnHand> gather_hands(Geometry& geometry, const std::vector<HandLook>& hands)
{
    std::vector<DrawnHand> drawn;
    drawn.reserve(hands.size());
    for (const HandLook& hand : hands)
        drawn.push_back({add_hand(geometry, hand), hand.opacity, hand.glow});
    return drawn;
}

void DrawnHidden::set(const std::vector<std::array<float, 2>>& to)
{
    if (to == corners) return;
    const bool sound = to.size() % 3 == 0 && std::all_of(to.begin(), to.end(), [](const auto& c) {
                           return std::isfinite(c[0]) && std::isfinite(c[1]);
                       });
    if (!sound) throw std::invalid_argument("a hidden area that is not of finite triangles");
    corners = to;
    glNamedBufferData(vertices, GLsizeiptr(corners.size() * sizeof corners[0]), corners.data(),
                      GL_STATIC_DRAW);
    glVertexArrayVertexBuffer(layout, 0, vertices, 0, sizeof corners[0]);
    glEnableVertexArrayAttrib(layout, 0);
    glVertexArrayAttribFormat(layout, 0, 2, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(layout, 0, 0);
}

void DrawnHidden::draw() const
{
    glBindVertexArray(layout);
    glDrawArrays(GL_TRIANGLES, 0, GLsizei(corners.size()));
}

}  // namespace knead
