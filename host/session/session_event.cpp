#include "host/session/session_event.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <type_traits>
#include <utility>

#include "host/base/json_reader.h"
#include "host/document/command_text.h"
#include "host/document/document_text.h"

namespace knead {
namespace {

static_assert(std::endian::native == std::endian::little, "bytes are written as memory is");

constexpr std::size_t most_joints = 1024, most_tools = 1024, most_polls = 1 << 20;
constexpr std::size_t most_text = std::size_t(16) << 20;

// Writes numbers, counts and texts; a Reader with the same calls reads them.
struct Writer {
    std::string& to;

    template <class T>
    requires std::is_arithmetic_v<T>
    void operator()(const T& number, const char* = "")
    {
        to.append(reinterpret_cast<const char*>(&number), sizeof number);
    }
    std::size_t count(std::size_t of, std::size_t)
    {
        (*this)(std::uint32_t(of));
        return of;
    }
    void text(const std::string& text)
    {
        count(text.size(), most_text);
        to += text;
    }
};

struct Reader {
    const std::string& from;
    const std::string& file;
    std::size_t at = 0;

    [[noreturn]] void refuse(const std::string& why) const
    {
        throw InputError(fmt::format("{}: events: byte {}: {}", file, at, why));
    }
    template <class T>
    requires std::is_arithmetic_v<T>
    void operator()(T& number, const char* what = "a number")
    {
        if (from.size() - at < sizeof number)
            refuse(fmt::format("expected {}, found the end", what));
        if constexpr (std::is_same_v<T, bool>) {
            const char byte = from[at++];
            if (byte != 0 && byte != 1) refuse("expected 0 or 1");
            number = byte == 1;
        } else {
            std::memcpy(&number, from.data() + at, sizeof number);
            at += sizeof number;
        }
    }
    std::size_t count(std::size_t, std::size_t most)
    {
        std::uint32_t found = 0;
        (*this)(found, "a count");
        if (found > most)
            refuse(fmt::format("expected a count of at most {}, found {}", most, found));
        if (found > from.size() - at) refuse("expected a count that fits the bytes");
        return found;
    }
    void text(std::string& text)
    {
        const std::size_t size = count(0, most_text);
        text.assign(from, at, size);
        at += size;
    }
    bool done() const { return at == from.size(); }
};

// A number as its difference from that of the frame before.
template <class T>
void number(Writer& io, const T& value, const std::type_identity_t<T>& before)
{
    using Bits = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;
    io(Bits(std::bit_cast<Bits>(value) ^ std::bit_cast<Bits>(before)));
}
template <class T>
void number(Reader& io, T& value, const std::type_identity_t<T>& before)
{
    using Bits = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;
    Bits bits = 0;
    io(bits);
    value = std::bit_cast<T>(Bits(bits ^ std::bit_cast<Bits>(before)));
    if (!std::isfinite(value)) io.refuse("expected a finite number");
}

template <class Io, class J, class Before>
void joint(Io& io, J& j, const Before& before)
{
    number(io, j.q.w, before.q.w), number(io, j.q.x, before.q.x);
    number(io, j.q.y, before.q.y), number(io, j.q.z, before.q.z);
    number(io, j.p.x, before.p.x), number(io, j.p.y, before.p.y), number(io, j.p.z, before.p.z);
}

template <class Io>
constexpr bool reads = std::is_same_v<Io, Reader>;

// Sets the length of a list when reading.
template <class Io, class List>
void length(Io& io, List& list, std::size_t most)
{
    const std::size_t count = io.count(list.size(), most);
    if constexpr (reads<Io>) list.resize(count);
}

template <class Io, class Joints>
void joints(Io& io, Joints& list, const std::vector<Joint<double>>& before)
{
    length(io, list, most_joints);
    for (std::size_t i = 0; i < list.size(); ++i)
        joint(io, list[i], i < before.size() ? before[i] : Joint<double>{});
}

// `last`: motion of the frame before. Most frames begin where it ended.
template <class Io, class M>
void motion(Io& io, M& m, Motion& last)
{
    bool follows = false;
    if constexpr (!reads<Io>)
        follows = m.from.size() == last.to.size() &&
                  (m.from.empty() || std::memcmp(m.from.data(), last.to.data(),
                                                 m.from.size() * sizeof m.from[0]) == 0);
    io(follows);
    if constexpr (reads<Io>)
        if (follows) m.from = last.to;
    if (!follows) joints(io, m.from, last.to);
    joints(io, m.to, last.to);
    length(io, m.active, most_tools);
    for (auto& a : m.active) io(a);
    length(io, m.size, most_tools);
    for (auto& s : m.size) number(io, s, 0.0f);
    length(io, m.stretch, most_tools);
    for (auto& s : m.stretch) number(io, s.across, 1.0f), number(io, s.along, 1.0f);
    last.to = m.to;
}

template <class Io, class E>
void body(Io& io, E& e, Motion& last, const std::string& file)
{
    using Event = std::remove_const_t<E>;
    if constexpr (std::is_same_v<Event, FrameEvent>) {
        number(io, e.time, 0.0), number(io, e.duration, 0.0);
        io(e.cut_after);
        std::vector<char> taken(e.taken.begin(), e.taken.end());
        length(io, taken, most_polls);
        for (char& one : taken) io(one);
        if constexpr (reads<Io>) e.taken.assign(taken.begin(), taken.end());
        motion(io, e.motion, last);
    } else if constexpr (std::is_same_v<Event, HashEvent>) {
        io(e.frame), io(e.hash);
    } else if constexpr (std::is_same_v<Event, CommandEvent> ||
                         std::is_same_v<Event, PreparationEvent>) {
        std::string text;
        int origin = 0;
        if constexpr (std::is_same_v<Event, CommandEvent>) {
            origin = int(e.issued.origin);
            io(e.issued.serial), io(origin), io(e.issued.drag);
            if constexpr (!reads<Io>) text = json_of(e.issued.command).dump();
        } else if constexpr (!reads<Io>) {
            text = json_of(Command(e.command)).dump();
        }
        io.text(text);
        if constexpr (reads<Io>) {
            // As in the document, files of objects may be anywhere.
            Command command = read_command(parse_json(text, file), file, "", ".");
            if constexpr (std::is_same_v<Event, CommandEvent>) {
                if (origin < 0 || origin > int(Origin::replay)) io.refuse("an unknown origin");
                e.issued.origin = Origin(origin);
                e.issued.command = std::move(command);
            } else if (AddObject* adds = std::get_if<AddObject>(&command)) {
                e.command = std::move(*adds);
            } else {
                io.refuse("expected an object to be prepared");
            }
        }
    } else if constexpr (std::is_same_v<Event, StepBegun>) {
        io(e.id), io(e.parent), io.text(e.label);
    } else if constexpr (std::is_same_v<Event, StepCaptured>) {
        io(e.id), io(e.unchanged);
    } else if constexpr (std::is_same_v<Event, StepRestored>) {
        io(e.id);
    } else {
        static_assert(std::is_same_v<Event, RunBegun>);
        std::string text;
        if constexpr (!reads<Io>)
            if (e.document) text = document_text(*e.document);
        io(e.state), io.text(text);
        if constexpr (reads<Io>)
            if (!text.empty())
                e.document = std::make_shared<const Document>(parse_document(text, file, ""));
    }
}

template <std::size_t... I>
SessionEvent event_of(std::size_t type, Reader& io, Motion& last, std::index_sequence<I...>)
{
    SessionEvent event;
    const bool known =
        ((type == I ? (body(io, event.emplace<I>(), last, io.file), true) : false) || ...);
    if (!known) io.refuse(fmt::format("an unknown event {}", type));
    return event;
}

template <class Io, class F>
void hands(Io& io, F& frame, HandFrame& last)
{
    number(io, frame.time, 0.0);
    for (const Side side : {left, right}) {
        auto& hand = frame.hand[side];
        const Hand& before = last.hand[side];
        io(hand.tracked);
        bool any = false;  // else its joints are those of the frame before
        if constexpr (!reads<Io>)
            any = std::memcmp(&hand.joints, &before.joints, sizeof hand.joints) != 0 ||
                  hand.radius != before.radius || hand.valid != before.valid;
        io(any);
        if constexpr (reads<Io>)
            if (!any)
                hand.joints = before.joints, hand.radius = before.radius, hand.valid = before.valid;
        for (std::size_t j = 0; any && j < joint_count; ++j) {
            joint(io, hand.joints[j], before.joints[j]);
            number(io, hand.radius[j], before.radius[j]);
            io(hand.valid[j]);
        }
    }
    last = frame;
}

}  // namespace

void EventWriter::add(const SessionEvent& event)
{
    Writer io{bytes};
    io(std::uint8_t(event.index()));
    std::visit([&](const auto& e) { body(io, e, last, {}); }, event);
}

void EventWriter::add(const HandFrame& frame)
{
    Writer io{bytes};
    hands(io, frame, last_hands);
}

std::string EventWriter::take()
{
    last = {}, last_hands = {};
    return std::exchange(bytes, {});
}

std::vector<SessionEvent> events_in(const std::string& bytes, const std::string& file)
{
    std::vector<SessionEvent> all;
    Reader io{bytes, file};
    Motion last;
    while (!io.done()) {
        std::uint8_t type = 0;
        io(type);
        all.push_back(event_of(type, io, last,
                               std::make_index_sequence<std::variant_size_v<SessionEvent>>{}));
    }
    return all;
}

std::vector<HandFrame> hands_in(const std::string& bytes, const std::string& file)
{
    std::vector<HandFrame> all;
    Reader io{bytes, file};
    HandFrame last;
    while (!io.done()) hands(io, all.emplace_back(), last);
    return all;
}

}  // namespace knead
