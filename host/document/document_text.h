// Documents, and their objects, as canonical JSON.
#pragma once
#include <string>

#include "host/base/json_reader.h"
#include "host/document/document.h"

namespace knead {

// Numbers to the bit: equal documents have equal texts. hash() is of this text.
std::string document_text(const Document& document);
// Reads what document_text() writes, to the bit, of documents of scenes and of commands. Strict:
// all keys of the document, known keys, ranges and rules of reduce(). `file`: for messages.
// `folder`: of the files that objects name by a relative path; "": paths stay as they are. Throws
// InputError.
Document parse_document(const std::string& text, const std::string& file,
                        const std::string& folder);

// An object of a document, with the keys of a scene's and `id`, `locked`, `hidden`.
Json json_of(const SceneObject& object);
// Reads what json_of() writes; without `id` it is 0. `folder`: see read_object(). Throws
// InputError.
SceneObject read_scene_object(ObjectReader& r, const std::string& folder);

}  // namespace knead
