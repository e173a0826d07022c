// The bytes of a checkpoint of version 6, which knead reads and writes no more.
#pragma once
#include <xxhash.h>

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/run/checkpoint.h"
#include "host/session/stored_state_body.h"
#include "tests/folder.h"

namespace knead {

// What a run keeps beside its state, as the present version has it.
inline Json record_facts(const std::string& file)
{
    const SessionFile session(file);
    const std::string bytes = session.chunks().payload(*session.run_record());
    return Json::from_cbor(bytes);
}

// Precondition: write_checkpoint() takes it.
inline std::string checkpoint_6(const Checkpoint& c)
{
    const Folder folder;
    write_checkpoint(folder / "present.knead", c);
    Json facts = record_facts(folder / "present.knead");
    facts.erase("schema");
    each_state_fact(c.stored, [&](const char* key, const auto& value) { facts[key] = value; });
    write_lengths(c.stored, facts);
    const std::vector<std::uint8_t> cbor = Json::to_cbor(facts);
    std::string all = "knead.checkpoint";
    NumberWriter write{all};
    write(std::uint32_t(6)), write(std::uint32_t(0));
    write(std::uint64_t(cbor.size())), write(std::uint64_t(body_bytes(c.stored)));
    all.append(reinterpret_cast<const char*>(cbor.data()), cbor.size());
    write_body(c.stored, all);
    write(std::uint64_t(XXH64(all.data(), all.size(), 0)));
    return all;
}

}  // namespace knead
