// What a file is for a window into which it is dropped, or that is started with it.
#pragma once
#include <string>
#include <variant>

#include "host/live/live_session.h"

namespace knead {

enum class DroppedKind { scene, session, splats, mesh, other };
// By its content; .splat and .obj, which have no first bytes of their own, by extension. Throws
// InputError with the path for a file that cannot be read, or is a folder.
DroppedKind dropped_kind(const std::string& path);

// Whether it is one of the kinds that become an object: splats or a mesh. False for what cannot be
// read.
bool adds_object(const std::string& file);

// Opens a scene or a session (Open without settings), or adds splats to the scene as an object on
// free ground, or a mesh where other new objects appear (AddObject); else why not. Reads the first
// bytes only: what is wrong beyond them, the session says when it applies the command.
std::variant<Command, Refusal> command_for_file(const std::string& path, const LiveState& state);
// Why the file is refused, without the path; "" for scenes, sessions, splats and meshes.
std::string refusal_of(DroppedKind kind);

}  // namespace knead
