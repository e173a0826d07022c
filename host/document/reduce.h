// A document after a command. Pure: no simulator, no files.
#pragma once
#include <cstdint>
#include <variant>

#include "host/document/command.h"

namespace knead {

// Gives rising ids to new objects, none twice. One per session; reset does not lower it.
class IdSource {
  public:
    explicit IdSource(std::uint32_t used = 0) : last(used) {}
    ObjectId next() { return {++last}; }
    bool used(ObjectId id) const { return id.value <= last; }
    void use(ObjectId id) { last = id.value > last ? id.value : last; }
    std::uint32_t most() const { return last; }

  private:
    std::uint32_t last;
};

// The document after the command, or why the command is refused; a refusal uses no id. Commands of
// the session leave the document as it is (the same pointer), but their objects are checked.
std::variant<DocumentPtr, Refusal> reduce(const DocumentPtr& document, const Command& command,
                                          IdSource& ids);

// The object that a reference means.
std::variant<ObjectId, Refusal> resolved(const Document& document, const ObjectRef& object,
                                         const std::string& field = "object");
// The command with ids in place of names. Precondition: reduce() accepts it.
Command with_ids(const Document& document, Command command);

}  // namespace knead
