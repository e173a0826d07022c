#include "host/session/stored_state.h"

#include <xxhash.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "host/base/cbor.h"
#include "host/document/command_table.h"
#include "host/document/document_text.h"
#include "host/scene/names.h"
#include "host/session/stored_state_body.h"

namespace knead {
namespace {

//     length of the facts [bytes], facts: CBOR, arrays, XXH64 of all before
constexpr const char* state_schema = "knead.state/1";
constexpr long most_frames = 1000000000000000;
constexpr std::size_t frame_bytes = 2 * sizeof(std::uint64_t);  // length and hash

using Constants = Material<double>;
constexpr Bounds any_number{-std::numeric_limits<double>::infinity(),
                            std::numeric_limits<double>::infinity()};
constexpr std::tuple material_fields{
    command_field("elasticity", &Constants::elasticity, ""),
    command_field("plasticity", &Constants::plasticity, ""),
    command_field("density", &Constants::density, "", any_number),
    command_field("mu", &Constants::mu, "", any_number),
    command_field("lambda", &Constants::lambda, "", any_number),
    command_field("bulk", &Constants::bulk, "", any_number),
    command_field("yield", &Constants::yield, "", any_number),
    command_field("hardening", &Constants::hardening, "", any_number),
    command_field("yield_floor", &Constants::yield_floor, "", any_number),
    command_field("friction", &Constants::friction, "", any_number),
    command_field("cohesion", &Constants::cohesion, "", any_number),
    command_field("compress", &Constants::compress, "", any_number),
    command_field("stretch", &Constants::stretch, "", any_number),
    command_field("snow", &Constants::snow, "", any_number),
    command_field("viscosity", &Constants::viscosity, "", any_number),
    command_field("exponent", &Constants::exponent, "", any_number),
    command_field("mass", &Constants::mass, "", any_number),
    command_field("volume", &Constants::volume, "", any_number),
    command_field("category", &Constants::category, "", {0, 255})};
static_assert(std::tuple_size_v<decltype(material_fields)> == arity<Constants, 32>(),
              "a member without a field, or a field too many");

template <class M, class Visit>
void each_constant(M& material, const Visit& visit)
{
    std::apply([&](const auto&... f) { (visit(f, material.*(f.member)), ...); }, material_fields);
}

// Writes a constant.
struct ConstantWriter {
    Json& to;

    template <class F>
    void operator()(const F& f, Elasticity value) const
    {
        to[f.key] = name_of(elasticities, value);
    }
    template <class F>
    void operator()(const F& f, Plasticity value) const
    {
        to[f.key] = name_of(plasticities, value);
    }
    template <class F, class T>
    void operator()(const F& f, T number) const
    {
        to[f.key] = number;
    }
};

// Reads a constant.
struct ConstantReader {
    ObjectReader& r;

    template <class F>
    void operator()(const F& f, Elasticity& value) const
    {
        r.required(f.key, "a name"), value = r.choice(f.key, elasticities, value);
    }
    template <class F>
    void operator()(const F& f, Plasticity& value) const
    {
        r.required(f.key, "a name"), value = r.choice(f.key, plasticities, value);
    }
    template <class F>
    void operator()(const F& f, double& number) const
    {
        number = r.number(f.key, f.range);
    }
    template <class F>
    void operator()(const F& f, int& number) const
    {
        r.required(f.key, "a whole number");
        number = r.whole(f.key, int(f.range.low), int(f.range.high), number);
    }
};

// Whether the material is that of a removed object: to the bit.
bool removed(const Constants& material)
{
    bool zero = true;
    const auto none = [](auto value) {
        if constexpr (std::is_same_v<decltype(value), double>)
            return std::bit_cast<std::uint64_t>(value) == 0;
        else
            return value == decltype(value){};
    };
    each_constant(material, [&](const auto&, auto value) { zero = zero && none(value); });
    return zero;
}

// Calls fact(key, value) for each fact except the lengths of the arrays.
template <class S, class Visit>
void each_fact(S& of, Visit&& fact)
{
    auto& [state, splats, local, document, numbers, ids_used, frames, time] = of;
    each_state_fact(of, fact);
    fact("document", document);
    fact("numbers", numbers);
    fact("ids_used", ids_used);
    fact("frames", frames);
    fact("time", time);
}

template <class T>
Json to_fact(const T& value)
{
    return value;
}
Json to_fact(const DocumentPtr& document) { return document_text(*document); }
Json to_fact(const ObjectNumbers& numbers) { return json_of(numbers); }

Json facts_json(const StoredState& of)
{
    Json facts = {{"schema", state_schema}};
    each_fact(of, [&](const char* key, const auto& value) { facts[key] = to_fact(value); });
    write_lengths(of, facts);
    return facts;
}

template <class T>
void take_fact(const Json& from, T& value, const std::string&)
{
    from.get_to(value);
}
void take_fact(const Json& from, DocumentPtr& document, const std::string& file)
{
    document = std::make_shared<const Document>(
        parse_document(from.get_ref<const std::string&>(), file + ": document", ""));
}
void take_fact(const Json& from, ObjectNumbers& numbers, const std::string& file)
{
    numbers = numbers_in(from, file + ": numbers");
}

[[noreturn]] void refuse(const std::string& file, const std::string& why)
{
    throw InputError(file + ": " + why);
}

// Each object of the document has a number.
void check_numbers(const StoredState& of, const std::string& file)
{
    bool all = of.document->objects.size() == of.numbers.number.size();
    for (const auto& o : of.document->objects) {
        const auto at = of.numbers.number.find(o->id);
        // A nozzle may have laid no clay.
        all = all && at != of.numbers.number.end() &&
              (!at->second.empty() || o->source.shape == ShapeKind::strand);
    }
    if (!all) refuse(file, "expected the numbers of the objects of its document, found others");
    if (of.ids_used > highest_id ||
        (!of.document->objects.empty() && of.ids_used < of.document->objects.back()->id.value))
        refuse(file,
               "/ids_used: expected that of its document, found " + std::to_string(of.ids_used));
    if (of.frames < 0 || of.frames > most_frames || !(of.time >= 0) || !std::isfinite(of.time))
        refuse(file, "expected frames and a time of at least 0, found others");
}

std::uint64_t number_at(const std::string& bytes, std::size_t at)
{
    std::uint64_t number;
    std::memcpy(&number, bytes.data() + at, sizeof number);
    return number;
}

StoredState state_in(const Json& facts, const char* body, std::uint64_t body_size,
                     const std::string& file)
{
    StoredState s;
    if (facts.at("schema") != state_schema)
        refuse(file, std::string("/schema: expected ") + state_schema + ", found " +
                         described(facts.at("schema")));
    each_fact(s, [&](const char* key, auto& value) { take_fact(facts.at(key), value, file); });
    copy_cloud_facts(s);
    check_numbers(s, file);
    check_lengths(s, facts, body_size, file);
    read_body(s, facts, body);
    // Refuses unknown facts and numbers of other types.
    if (facts_json(s) != facts) refuse(file, "its facts are not those of a stored state");
    return s;
}

}  // namespace

std::string to_bytes(const StoredState& of)
{
    const std::vector<std::uint8_t> facts = Json::to_cbor(facts_json(of));
    std::string whole;
    whole.reserve(facts.size() + body_bytes(of) + frame_bytes);
    NumberWriter write{whole};
    write(std::uint64_t(facts.size()));
    whole.append(reinterpret_cast<const char*>(facts.data()), facts.size());
    write_body(of, whole);
    write(std::uint64_t(XXH64(whole.data(), whole.size(), 0)));
    return whole;
}

StoredState state_from(const std::string& bytes, const std::string& file)
{
    if (bytes.size() < frame_bytes) refuse(file, "expected a stored state, found its beginning");
    const std::size_t rest = bytes.size() - frame_bytes;
    const std::uint64_t length = number_at(bytes, 0);
    if (length > rest)
        refuse(file, "byte 0: expected the length of the facts, found " + std::to_string(length));
    if (XXH64(bytes.data(), bytes.size() - 8, 0) != number_at(bytes, bytes.size() - 8))
        refuse(file, "damaged: its checksum is not that of its bytes");
    const char* facts = bytes.data() + 8;
    try {
        const std::optional<Json> all = parse_cbor({facts, length});
        if (!all) refuse(file, "byte 8: expected the facts of a stored state, found others");
        return state_in(*all, facts + length, rest - length, file);
    } catch (const Json::exception& e) {
        refuse(file, std::string("its facts are not those of a stored state: ") + e.what());
    } catch (const std::out_of_range&) {
        refuse(file, "its splats are not those of a stored state");
    }
}

Json json_of(const ObjectNumbers& numbers)
{
    Json objects = Json::array(), materials = Json::array();
    for (const auto& [id, all] : numbers.number) {
        Json one = Json::array({id.value});
        for (const int number : all) one.push_back(number);
        objects.push_back(std::move(one));
    }
    for (const Constants& m : numbers.materials) {
        Json constants;  // of a removed object: null
        if (!removed(m)) each_constant(m, ConstantWriter{constants});
        materials.push_back(std::move(constants));
    }
    return {{"objects", std::move(objects)}, {"materials", std::move(materials)}};
}

ObjectNumbers numbers_in(const Json& value, const std::string& file)
{
    ObjectNumbers numbers;
    const auto list = [](ObjectReader& r, const char* key) -> const Json& {
        const Json& all = r.required(key, "an array");
        if (!all.is_array()) r.fail(key, "an array", described(all));
        return all;
    };
    ObjectReader::read(value, file, "", [&](ObjectReader& r) {
        for (const Json& one : list(r, "materials")) {
            Constants m{};
            const std::string place =
                r.pointer("materials") + "/" + std::to_string(numbers.materials.size());
            if (!one.is_null())
                ObjectReader::read(one, file, place,
                                   [&](ObjectReader& in) { each_constant(m, ConstantReader{in}); });
            numbers.materials.push_back(m);
        }
        std::set<int> seen;
        for (const Json& one : list(r, "objects")) {
            const auto in = [&](std::size_t i, std::uint64_t low, std::uint64_t end) {
                return one[i].is_number_integer() && one[i] >= low && one[i] < end;
            };
            bool known = one.is_array() && !one.empty() && in(0, 1, std::uint64_t(highest_id) + 1);
            std::vector<int> all;
            for (std::size_t i = 1; known && i < one.size(); ++i) {
                known = in(i, 0, numbers.materials.size()) && seen.insert(one[i].get<int>()).second;
                if (known) all.push_back(one[i].get<int>());
            }
            if (!known ||
                !numbers.number.emplace(ObjectId{one[0].get<std::uint32_t>()}, all).second)
                r.fail("objects", "an object and its numbers, each once", described(one));
        }
    });
    return numbers;
}

}  // namespace knead
