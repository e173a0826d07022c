// A rectangular part of a texture, as a panel shows it.
#pragma once

namespace knead {

// Whoever draws the texture generates its mipmaps and sets its filters.
struct PanelTexture {
    unsigned name = 0;     // GL; of an sRGB format, so that sampling gives linear values
    float u0 = 0, v0 = 0;  // texture coordinates of the upper left corner,
    float u1 = 1, v1 = 1;  // and of the lower right one

    // The rectangle of a picture that OpenGL drew into the texture: pixels count from its upper
    // left, texture coordinates from its lower left.
    static PanelTexture part(unsigned name, float x, float y, float width, float height,
                             float picture_width, float picture_height)
    {
        return {name, x / picture_width, 1 - y / picture_height, (x + width) / picture_width,
                1 - (y + height) / picture_height};
    }
};

}  // namespace knead
