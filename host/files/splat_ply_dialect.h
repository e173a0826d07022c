// Dialects of splat PLY: what the names of the properties and the comments say about the file.
#pragma once
#include <string>
#include <vector>

#include "host/files/ply.h"

namespace knead {

// Throws InputError, naming the method, for files whose rows are not Gaussians with their own
// colours: anchors of Scaffold-GS and Octree-GS, other kernels, moving splats, codebooks.
void refuse_other_kernels(const PlyFile& header, const std::string& path);

// Vertex properties that are not read and may matter, in file order. Normals, labels, and colours
// beside f_dc are not among them.
std::vector<std::string> unknown_properties(const PlyElement& vertex);

// Trained with a screen filter that keeps the total opacity: the last of the comments
// "SplatRenderMode: default|mip|2dgs" and "antialiased 0|1", in any case.
bool says_antialiased(const PlyFile& header);

// Notes for the user from the comments and from the elements behind the vertices: the vertical
// axis, linear colours. `file` has the values of the elements other than "vertex".
std::vector<std::string> dialect_notes(const PlyFile& file);

}  // namespace knead
