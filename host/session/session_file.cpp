#include "host/session/session_file.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <utility>

#include "host/base/errors.h"
#include "host/base/folder_lock.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/base/outputs.h"
#include "host/base/paths.h"
#include "host/document/document_text.h"
#include "host/scene/new_scene.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

constexpr ChunkKind meta_kind("META"), scene_kind("SCEN"), event_kind("EVNT"), input_kind("INPT"),
    step_kind("STEP"), difference_kind("DIFF"), rows_kind("ROWS"), splats_kind("SPLT"),
    picture_kind("THMB"), saved_kind("SAVD");
constexpr std::size_t event_bytes = std::size_t(1) << 20;
constexpr long key_every = 16;  // steps: whole rows
constexpr StepId highest_step = StepId(1) << 53;

bool known(ChunkKind kind)
{
    for (const ChunkKind& one :
         {meta_kind, scene_kind, event_kind, input_kind, step_kind, difference_kind, rows_kind,
          splats_kind, state_kind, picture_kind, saved_kind, run_record_kind})
        if (kind == one) return true;
    return false;
}

std::string dump(const Json& value)
{
    return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// The three texts of a difference, each after its length.
std::string difference_bytes(const ClayEdge& edge)
{
    std::string bytes;
    for (const std::string* part : {&edge.from_parent, &edge.parent_whole, &edge.whole}) {
        const std::uint64_t size = part->size();
        bytes.append(reinterpret_cast<const char*>(&size), sizeof size);
        bytes += *part;
    }
    return bytes;
}

ClayEdge difference_in(const std::string& bytes, const std::string& file)
{
    ClayEdge edge;
    std::size_t at = 0;
    for (std::string* part : {&edge.from_parent, &edge.parent_whole, &edge.whole}) {
        std::uint64_t size = 0;
        if (bytes.size() - at < sizeof size) throw InputError(file + ": a step is cut");
        std::copy_n(bytes.data() + at, sizeof size, reinterpret_cast<char*>(&size));
        at += sizeof size;
        if (size > bytes.size() - at) throw InputError(file + ": a step is cut");
        part->assign(bytes, at, size);
        at += size;
    }
    if (at != bytes.size()) throw InputError(file + ": a step has too many bytes");
    return edge;
}

// A part of a step, as a stored state that has nothing else.
StoredState part_of(const HistoryStep& step)
{
    StoredState state;
    state.document = step.document, state.numbers = *step.objects;
    if (!step.document->objects.empty()) state.ids_used = step.document->objects.back()->id.value;
    return state;
}

StoredState splats_of(const HistoryStep& step)
{
    StoredState state = part_of(step);
    state.splats = *step.splats;
    state.state.contents.gaussians.resize(step.splats->count());  // one per splat
    return state;
}

StoredState beginning_of(const HistoryStep& step)
{
    StoredState state = part_of(step);
    state.state.contents = *step.beginning;
    for (std::size_t i = 0; i < step.beginning->particles.size(); ++i)
        state.state.order.push_back(int(i));
    return state;
}

// The name of an installed scene; else the path as it is.
std::string shipped_name(const std::string& path)
{
    const std::string name = fs::path(path).filename().string();
    std::error_code problem;
    const std::string installed = shipped("scenes/" + name);
    return !installed.empty() && fs::equivalent(installed, path, problem) ? name : path;
}

std::string random_name()
{
    std::random_device random;
    std::uint32_t n[4];
    for (std::uint32_t& each : n) each = random();
    return fmt::format("{:08x}-{:04x}-4{:03x}-{:04x}-{:04x}{:08x}", n[0], n[1] & 0xffff, n[1] >> 20,
                       (n[2] & 0x3fff) | 0x8000, n[2] >> 16, n[3]);
}

[[noreturn]] void refuse_older_checkpoint(const std::string& file)
{
    throw InputError(file +
                     ": is a checkpoint of an older knead, and no session; `knead run --resume` "
                     "goes on with it");
}

ChunkFile opened(const std::string& file)
{
    try {
        return ChunkFile(file);
    } catch (const InputError&) {
        std::error_code none;
        if (fs::is_regular_file(file, none) && begins_older_checkpoint(read_start(file, 16)))
            refuse_older_checkpoint(file);
        throw;
    }
}

template <class T>
T member(const Json& of, const char* key, const std::string& file)
{
    try {
        const Json& value = of.at(key);
        if (std::is_integral_v<T> && value.is_number_float())
            throw InputError(fmt::format("{}: \"{}\": expected a whole number", file, key));
        return value.get<T>();
    } catch (const Json::exception&) {
        throw InputError(fmt::format("{}: its \"{}\" is not that of a session", file, key));
    }
}

}  // namespace

SessionMeta new_session()
{
    SessionMeta meta;
    meta.session = random_name();
    meta.program = knead_version();
    meta.begun = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
    return meta;
}

Chunk chunk_of(const SessionMeta& meta)
{
    return chunk_of(meta_kind, dump({{"session", meta.session},
                                     {"program", meta.program},
                                     {"begun", meta.begun},
                                     {"device", meta.device},
                                     {"deterministic", meta.deterministic},
                                     {"stepped", meta.stepped}}));
}

Chunk chunk_of(const SceneSource& scene)
{
    return chunk_of(scene_kind, dump({{"path", shipped_name(scene.path)},
                                      {"text", scene.text},
                                      {"settings", scene.settings}}));
}

std::string log_folder()
{
    const auto set = [](const char* name) -> std::string {
        const char* value = std::getenv(name);
        return value && fs::path(value).is_absolute() ? value : "";
    };
    fs::path folder;
    if (const std::string state = set("XDG_STATE_HOME"); !state.empty())
        folder = fs::path(state) / "knead";
    else if (const std::string home = set("HOME"); !home.empty())
        folder = fs::path(home) / ".local" / "state" / "knead";
    else
        folder = fs::temp_directory_path() / fmt::format("knead-{}", getuid());
    std::error_code problem;
    fs::create_directories(folder, problem);
    if (problem) throw OutputError(fmt::format("{}: {}", folder.string(), problem.message()));
    ::chmod(folder.c_str(), 0700);  // hands are personal data
    return folder.string();
}

std::optional<Refusal> refusal_of(const Save& command)
{
    if (ending(command.file) == session_ending) return {};
    return Refusal{fmt::format("expected a name that ends in {}", session_ending), "file"};
}

SessionWriter::SessionWriter(const SessionMeta& meta, const SceneSource& scene,
                             const Journal::Options& options)
    : journal(std::make_unique<Journal>(
          (fs::path(log_folder()) / (meta.session + log_ending)).string(), options))
{
    journal->add(chunk_of(meta));
    journal->add(chunk_of(scene));
}

SessionWriter::SessionWriter(const SessionFile& onto, const Journal::Options& options)
    : journal(std::make_unique<Journal>(onto.chunks(), options))
{
    for (const ChunkHead& head : onto.chunks().chunks()) {
        if (head.kind == state_kind) last_state = std::max(last_state, head.id);
        if (head.kind == splats_kind) last_splats = std::max(last_splats, head.id);
    }
    steps_since_key = key_every;
    steps = onto.steps();
    *saved_steps = onto.ended() ? steps : steps - 1;
}

SessionWriter::~SessionWriter() { hand_over(); }

void SessionWriter::add(const SessionEvent& event)
{
    events.add(event);
    if (events.size() > event_bytes) hand_over();
}

void SessionWriter::add_hands(const HandFrame& frame)
{
    hands.add(frame);
    if (hands.size() > event_bytes) hand_over();
}

void SessionWriter::hand_over()
{
    const auto pass = [&](EventWriter& from, ChunkKind kind) {
        if (from.size() == 0) return;
        const auto bytes = std::make_shared<const std::string>(from.take());
        journal->add([bytes, kind] { return chunk_of(kind, *bytes); }, bytes->size());
    };
    pass(hands, input_kind), pass(events, event_kind);
    handed = wall_seconds();
}

void SessionWriter::poll()
{
    constexpr double oldest = 0.2;  // [s]
    if (wall_seconds() - handed > oldest) hand_over();
}

// Steps whose splats are those of the step before share their chunk.
void SessionWriter::add_step(const HistoryStep& step, const FutureCapture& made)
{
    hand_over();
    if (step.splats != splats_written) {
        splats_written = step.splats;
        if (step.splats)
            journal->add(
                [step, id = ++last_splats] {
                    return chunk_of(splats_kind, to_bytes(splats_of(step)), id);
                },
                step.splats->count() * 100);
    }
    std::uint64_t beginning = 0;
    if (step.beginning) {
        beginning = ++last_state;
        journal->add(
            [step, beginning] {
                return chunk_of(state_kind, to_bytes(beginning_of(step)), beginning);
            },
            step.beginning->particles.size() * 100);
    }
    const bool key = made.valid() && ++steps_since_key >= key_every;
    if (key) steps_since_key = 0;
    ++steps;
    const std::uint64_t with_splats = step.splats ? last_splats : 0;
    journal->add(
        [step, made, beginning, with_splats] {
            const std::uint64_t hash = made.valid() ? made.get().hash : 0;
            return chunk_of(step_kind,
                            dump({{"id", step.id},
                                  {"parent", step.parent},
                                  {"label", step.label},
                                  {"frame", step.frame},
                                  {"document", document_text(*step.document)},
                                  {"numbers", json_of(*step.objects)},
                                  {"splats", with_splats},
                                  {"beginning", beginning},
                                  {"unchanged", !made.valid()},
                                  {"hash", fmt::format("{:016x}", hash)}}),
                            step.id, step.parent);
        },
        1000);
    if (!made.valid()) return;
    journal->add(
        [id = step.id, made] {
            return chunk_of(difference_kind, difference_bytes(*made.get().edge), id);
        },
        0, Journal::Drop::difference);
    if (key)
        journal->add(
            [id = step.id, made] {
                const Capture& step_made = made.get();
                return chunk_of(rows_kind, encoded(*step_made.rows, step_made.steps.get()), id);
            },
            0, Journal::Drop::difference);
}

void SessionWriter::add_beginning(const HistoryStep& step, std::shared_ptr<const ClayRows> rows)
{
    add_step(step, {});
    journal->add([rows, id = step.id] { return chunk_of(rows_kind, encoded(*rows), id); },
                 rows->count * 48);
    steps_since_key = 0, *saved_steps = steps;
}

std::uint64_t SessionWriter::add_state(std::function<StoredState()> make, std::size_t bytes)
{
    hand_over();
    const std::uint64_t id = ++last_state;
    journal->add(
        [make = std::move(make), id] { return chunk_of(state_kind, to_bytes(make()), id); }, bytes,
        Journal::Drop::state);
    return id;
}

void SessionWriter::set_picture(std::string png)
{
    journal->add(chunk_of(picture_kind, png, 0, 0, chunk_ancillary));
}

void SessionWriter::save(const std::string& to, bool input, StepId step,
                         std::function<StoredState()> make,
                         std::function<void(const std::string&)> written)
{
    hand_over();
    const std::uint64_t id = ++last_state;
    const auto more = [to, id, step, make = std::move(make)] {
        std::vector<Chunk> chunks;
        chunks.push_back(chunk_of(state_kind, to_bytes(make()), id));
        // Without a path: the file may be moved, or given to others.
        const Json saved{{"file", fs::path(to).filename().string()}, {"step", step}};
        chunks.push_back(chunk_of(saved_kind, dump(saved), 0, 0, chunk_ancillary));
        return chunks;
    };
    const auto without_hands = [](const ChunkHead& head) {
        return head.kind != event_kind && head.kind != input_kind;
    };
    std::function<bool(const ChunkHead&)> keep;
    if (!input) keep = without_hands;
    const auto ended = [this, to, saved = saved_steps, all = steps,
                        then = std::move(written)](const std::string& why) {
        if (why.empty()) {
            *saved = all;
            const Json end{{"saved", fs::absolute(to).string()}, {"steps", all}};
            journal->add(chunk_of(saved_kind, dump(end), 0, 0, chunk_ancillary));
        }
        then(why);
    };
    journal->save(to, more, ended, keep);
}

SessionFile::SessionFile(const std::string& from) : file(opened(from))
{
    bool has_scene = false;
    long saved_steps = -1;
    std::uint64_t last_state = 0;
    std::set<StepId> stored{};  // steps
    const ChunkHead* last_saved = nullptr;
    for (const ChunkHead& head : file.chunks()) {
        if (head.kind == meta_kind && of.session.empty()) {
            const Json json = parse_json(file.payload(head), from);
            of = {member<std::string>(json, "session", from),
                  member<std::string>(json, "program", from),
                  member<std::string>(json, "begun", from),
                  member<std::string>(json, "device", from),
                  member<bool>(json, "deterministic", from),
                  member<bool>(json, "stepped", from)};
        } else if (head.kind == scene_kind) {
            const Json json = parse_json(file.payload(head), from);
            source = {file_or_shipped(member<std::string>(json, "path", from)),
                      member<std::string>(json, "text", from),
                      member<std::vector<std::string>>(json, "settings", from)};
            has_scene = true;
        } else if (head.kind == saved_kind) {
            const Json json = parse_json(file.payload(head), from);
            if (json.is_object() && json.contains("saved")) {  // in a log
                saved = member<std::string>(json, "saved", from);
                saved_steps = member<long>(json, "steps", from);
            } else {
                at = member<StepId>(json, "step", from);
                at_state = last_state, last_saved = &head;
            }
        } else if (head.kind == run_record_kind) {
            at_state = last_state;
        } else if (!known(head.kind) && !head.ancillary() && unknown.empty()) {
            unknown =
                fmt::format("it has parts of kind \"{}\", of a newer knead", head.kind.text());
        }
        if (head.kind == state_kind) last_state = head.id;
        if (head.kind == step_kind) stored.insert(head.id), at_state = 0;
    }
    if (of.session.empty() || !has_scene)
        throw InputError(from + ": expected a session, found none in the file");
    is_ended = at_state != 0 || saved_steps == steps();
    if (!stored.empty()) most_step_id = *stored.rbegin();
    follow_events(stored, last_saved);
    if (most_step_id > highest_step) throw InputError(from + ": a step has an impossible number");
}

// Finds the step that was current last, of those stored, and the ids that were given.
void SessionFile::follow_events(const std::set<StepId>& stored, const ChunkHead* last_saved)
{
    const auto is_at = [&](StepId id) {
        if (!at_state && stored.contains(id)) at = id;
    };
    bool since_saved = false;
    const auto follow = [&](const SessionEvent& event) {
        if (const StepCaptured* captured = std::get_if<StepCaptured>(&event)) is_at(captured->id);
        if (const StepRestored* restored = std::get_if<StepRestored>(&event)) {
            if (since_saved) at_state = 0;  // the clay is another step's
            is_at(restored->id);
        }
        if (const StepBegun* begun = std::get_if<StepBegun>(&event))
            most_step_id = std::max(most_step_id, begun->id);
        if (const CommandEvent* command = std::get_if<CommandEvent>(&event))
            for (const ObjectId id : new_ids(command->issued.command))
                most_object_id = std::max(most_object_id, id.value);
    };
    for (const ChunkHead& head : file.chunks()) {
        since_saved = since_saved || &head == last_saved;
        if (head.kind != event_kind) continue;
        for (const SessionEvent& event : events_in(file.payload(head), file.path())) follow(event);
    }
}

const ChunkHead* SessionFile::run_record() const
{
    const std::vector<ChunkHead>& all = file.chunks();
    return !all.empty() && all.back().kind == run_record_kind ? &all.back() : nullptr;
}

void SessionFile::each_event(const std::function<bool(const SessionEvent&)>& visit) const
{
    for (const ChunkHead& head : file.chunks()) {
        if (head.kind != event_kind) continue;
        for (const SessionEvent& event : events_in(file.payload(head), file.path()))
            if (!visit(event)) return;
    }
}

std::vector<HandFrame> SessionFile::hands() const
{
    std::vector<HandFrame> all;
    for (const ChunkHead& head : file.chunks()) {
        if (head.kind != input_kind) continue;
        for (const HandFrame& frame : hands_in(file.payload(head), file.path()))
            if (all.empty() || frame.time > all.back().time) all.push_back(frame);
    }
    return all;
}

long SessionFile::steps() const
{
    return std::ranges::count(file.chunks(), step_kind, &ChunkHead::kind);
}

long SessionFile::frames() const
{
    long count = 0;
    each_event([&](const SessionEvent& event) {
        count += std::holds_alternative<FrameEvent>(event);
        return true;
    });
    return count;
}

std::vector<std::uint64_t> SessionFile::states() const
{
    std::vector<std::uint64_t> ids;
    for (const ChunkHead& head : file.chunks())
        if (head.kind == state_kind) ids.push_back(head.id);
    return ids;
}

StoredState SessionFile::state(std::uint64_t id) const
{
    for (const ChunkHead& head : file.chunks())
        if (head.kind == state_kind && head.id == id)
            return state_from(file.payload(head), file.path());
    throw InputError(fmt::format("{}: there is no state {}", file.path(), id));
}

std::string SessionFile::picture() const
{
    for (auto head = file.chunks().rbegin(); head != file.chunks().rend(); ++head)
        if (head->kind == picture_kind) return file.payload(*head);
    return "";
}

struct SessionFile::StoredStep {
    HistoryStep step;                 // without splats
    std::uint64_t splats = 0;         // id of their chunk; 0: none
    std::optional<std::string> hash;  // of its particles; none: they are its parent's
};

SessionFile::StoredStep SessionFile::step_in(const ChunkHead& head) const
{
    const std::string& name = file.path();
    const Json json = parse_json(file.payload(head), name);
    StoredStep stored;
    HistoryStep& step = stored.step;
    step.id = member<StepId>(json, "id", name), step.parent = member<StepId>(json, "parent", name);
    step.label = member<std::string>(json, "label", name);
    step.frame = member<long>(json, "frame", name);
    step.document = std::make_shared<const Document>(
        parse_document(member<std::string>(json, "document", name), name, ""));
    step.objects = std::make_shared<const ObjectNumbers>(
        numbers_in(member<Json>(json, "numbers", name), name));
    step.captured = true;
    if (const auto id = member<std::uint64_t>(json, "beginning", name)) {
        StoredState of_beginning = state(id);
        step.beginning =
            std::make_shared<const InitialState>(std::move(of_beginning.state.contents));
    }
    stored.splats = member<std::uint64_t>(json, "splats", name);
    if (!member<bool>(json, "unchanged", name))
        stored.hash = member<std::string>(json, "hash", name);
    if (step.id != head.id || step.parent > step.id)
        throw InputError(name + ": a step has the number of another");
    return stored;
}

// Steps without particles, and those after them, are left out. A step is written before its
// particles: those of an earlier step of its number, which was cut off there, are not its own.
void SessionFile::read_history(History& into, StepId current) const
{
    std::map<StepId, const ChunkHead*> steps, differences, rows;
    std::map<std::uint64_t, std::shared_ptr<const CarriedSplats>> splats;
    for (const ChunkHead& head : file.chunks()) {
        if (head.kind == step_kind)
            steps[head.id] = &head, differences.erase(head.id), rows.erase(head.id);
        if (head.kind == difference_kind) differences[head.id] = &head;
        if (head.kind == rows_kind) rows[head.id] = &head;
        if (head.kind == splats_kind)
            splats[head.id] = std::make_shared<const CarriedSplats>(
                state_from(file.payload(head), file.path()).splats);
    }
    for (const auto& [id, head] : steps) {
        StoredStep stored = step_in(*head);
        HistoryStep& step = stored.step;
        if (const auto found = splats.find(stored.splats); found != splats.end())
            step.splats = found->second;
        if (into.count() == 0) {
            const auto first = rows.find(step.id);
            if (first == rows.end()) continue;
            into.begin(step,
                       std::make_shared<const ClayRows>(decoded(file.payload(*first->second))));
            continue;
        }
        if (!into.find(step.parent) || into.find(step.id)) continue;
        if (!stored.hash) {
            into.insert(std::move(step), {});
        } else if (const auto found = differences.find(step.id); found != differences.end()) {
            Capture made;
            made.edge = std::make_shared<const ClayEdge>(
                difference_in(file.payload(*found->second), file.path()));
            made.hash = std::strtoull(stored.hash->c_str(), nullptr, 16);
            const ClayEdge& edge = *made.edge;
            if (hash_after(edge.whole.empty() ? edge.from_parent : edge.whole) != made.hash)
                throw InputError(file.path() + ": a step has the particles of another");
            into.insert(std::move(step), std::move(made));
        }
    }
    into.use_ids(most_step_id);
    if (steps.empty()) return;
    if (into.count() == 0) throw InputError(file.path() + ": it has no step with its clay");
    StepId there = into.current().id;
    for (const StepInfo& step : into.list())
        if (step.id <= current) there = step.id;
    into.go_to(there, into.rows_of(there));
    into.evict();
}

void compact_session(const SessionFile& from, const std::string& to)
{
    const std::uint64_t last = from.final_state();
    std::set<std::uint64_t> beginnings;  // states that steps begin with
    for (const ChunkHead& head : from.chunks().chunks())
        if (head.kind == step_kind) {
            const Json json = parse_json(from.chunks().payload(head), from.chunks().path());
            beginnings.insert(member<std::uint64_t>(json, "beginning", from.chunks().path()));
        }
    const ChunkHead* picture = nullptr;
    for (const ChunkHead& head : from.chunks().chunks())
        if (head.kind == picture_kind) picture = &head;
    const auto keep = [&](const ChunkHead& head) {
        if (head.kind == event_kind || head.kind == input_kind || head.kind == saved_kind)
            return false;
        if (head.kind == run_record_kind) return &head == from.run_record();
        if (head.kind == picture_kind) return &head == picture;
        if (head.kind == state_kind) return head.id == last || beginnings.contains(head.id);
        return true;
    };
    std::vector<Chunk> end;
    if (!from.run_record())  // which is the last chunk
        end.push_back(
            chunk_of(saved_kind,
                     dump({{"file", fs::path(to).filename().string()}, {"step", from.current()}}),
                     0, 0, chunk_ancillary));
    rewrite_chunks(from.chunks(), keep, end, to);
}

void verify_session(const SessionFile& file, const std::function<bool()>& stop)
{
    file.chunks().verify(stop);
    file.each_event([&](const SessionEvent&) { return !stop || !stop(); });
    file.hands();
    for (const std::uint64_t id : file.states()) {
        if (stop && stop()) return;
        file.state(id);
    }
    History all(std::size_t(1) << 40);
    file.read_history(all, file.current());
    for (const StepInfo& step : all.list()) {
        if (stop && stop()) return;
        all.rows_of(step.id);
    }
}

std::vector<Recoverable> recoverable_sessions()
{
    std::vector<Recoverable> found;
    std::error_code problem;
    for (const auto& entry : fs::directory_iterator(log_folder(), problem)) {
        const std::string path = entry.path().string();
        if (entry.path().extension() != log_ending || FolderLock::is_held(path)) continue;
        try {
            const SessionFile file(path);
            if (file.ended() || file.steps() < 2) continue;
            const auto written = fs::last_write_time(entry.path(), problem);
            const double age =
                std::chrono::duration<double>(fs::file_time_type::clock::now() - written).count();
            found.push_back(
                {path, file.meta().session, file.scene().path, age, file.steps(), file.picture()});
        } catch (const std::exception&) {  // a log that cannot be read is no use
        }
    }
    std::ranges::sort(found, {}, &Recoverable::age);
    return found;
}

Recording SessionFile::recording() const
{
    Recording all;
    all.name = "session", all.rate = 90;
    all.frames = hands();
    if (all.frames.empty()) throw InputError(file.path() + ": it has no recorded hands");
    const double begun = all.frames.front().time;
    for (HandFrame& frame : all.frames) frame.time -= begun;
    if (all.frames.size() > 1)
        all.rate = double(all.frames.size() - 1) / std::max(1e-3, all.frames.back().time);
    return all;
}

SessionFile::Clay SessionFile::clay() const
{
    if (at_state) {
        StoredState last = state(at_state);
        return {std::move(last.state.contents.particles), std::move(last.numbers.materials),
                std::move(last.document)};
    }
    History all(std::size_t(1) << 40);
    read_history(all, at);
    if (all.count() == 0)
        throw InputError(file.path() + ": it keeps no clay; `knead replay` computes it");
    const HistoryStep& step = all.current();
    const std::shared_ptr<const ClayRows> rows = all.resident();
    Clay found{{}, step.objects->materials, step.document};
    found.particles.reserve(rows->count);
    for (std::size_t i = 0; i < rows->count; ++i)
        found.particles.push_back(cast<double>(particle_at(*rows, i)));
    return found;
}

void delete_log(const std::string& file)
{
    const fs::path path = file;
    const FolderLock own(path.parent_path().string(), path.filename().string());
    std::error_code problem;
    fs::remove(path, problem);
    if (problem) throw OutputError(file + ": " + problem.message());
}

SessionFile session_to_continue(const std::string& file)
{
    SessionFile session(file);
    if (!session.read_only().empty())
        throw InputError(file + ": can be read, but not gone on with: " + session.read_only());
    const fs::path path = file;
    if (path.extension() == log_ending)
        FolderLock(path.parent_path().string(), path.filename().string());
    return session;
}

bool begins_older_checkpoint(std::string_view start)
{
    return start.starts_with("knead.checkpoint");
}

bool is_session(const std::string& file)
{
    if (file == new_scene_name) return false;
    const std::string start = read_start(file, 16);
    if (begins_older_checkpoint(start)) refuse_older_checkpoint(file);
    return begins_session(start);
}

}  // namespace knead
