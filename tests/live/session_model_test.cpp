// Sessions of random commands, gestures, undo, redo, go_to, reset, save, export, open and recovery,
// against a reference that keeps whole copies of each step.
#include <gtest/gtest.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <thread>

#include "host/live/live_session.h"
#include "host/live/session_log.h"
#include "host/scene/presets.h"
#include "tests/document/random.h"
#include "tests/folder.h"
#include "tests/live/state_difference.h"
#include "tests/sanitized.h"
#include "tests/session/clay_rows.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

using Rows = std::shared_ptr<const ClayRows>;
constexpr double rate = 90;  // frames per second

// A copy of the clay, by a hash of 128 bits: a thousand copies of large clay do not fit into
// memory. Of clay that is not large, all rows too.
class Copy {
  public:
    Copy() = default;
    explicit Copy(Rows of) : count(of->count)
    {
        XXH3_state_t* const hash = XXH3_createState();
        XXH3_128bits_reset(hash);
        const auto add = [&](const auto& numbers) {
            XXH3_128bits_update(hash, numbers.data(), numbers.size() * sizeof numbers[0]);
        };
        add(of->planes), add(of->object), add(of->sides), add(of->gaussians);
        digest = XXH3_128bits_digest(hash);
        XXH3_freeState(hash);
        if (count <= most_lossless_particles) whole = std::move(of);
        present = true;
    }
    explicit operator bool() const { return present; }
    friend bool same(const Copy& a, const Copy& b)
    {
        if (!a || !b || a.count != b.count || !XXH128_isEqual(a.digest, b.digest)) return false;
        return !a.whole || same_rows(*a.whole, *b.whole);
    }

  private:
    bool present = false;
    std::size_t count = 0;
    XXH128_hash_t digest{};
    Rows whole;
};

// About 2000 particles, which two hands reach.
constexpr const char* two_objects = R"({"schema": "knead.scene/1", "frame_rate": 90,
    "domain": {"edge": 0.48, "cells": 16}, "gravity": [0, -9.81, 0],
    "step": {"courant": 0.9}, "surface": {"nodes": 12},
    "objects": [
      {"name": "ball", "centre": [0.24, 0.17, 0.24], "diameter": 0.17,
       "material": {"preset": "clay", "young": 1e5, "yield": 1e3}},
      {"name": "block", "shape": "box", "centre": [0.36, 0.11, 0.34], "size": [0.12, 0.1, 0.1],
       "material": {"preset": "clay", "young": 1e5, "yield": 1e3}, "category": 1}],
    "hands": {"recording": "squeeze", "zoom": 0.6, "at": [0.24, 0.17, 0.24]}})";

struct ReferenceStep {
    StepId parent = 0;
    std::string label;
    DocumentPtr document;
    Copy rows;               // none: open
    bool unchanged = false;  // its rows are those of its parent
};
// All steps that a session ever had.
struct Reference {
    std::map<StepId, ReferenceStep> steps;
    StepId current = 0, last = 0;  // the highest id that was given
};
struct Clay {
    Rows rows;
    Quantisation steps;  // of a capture at this time
    DocumentPtr document;
    std::shared_ptr<const SavedState> state{};  // null: after a frame among several; large clay
    Copy copy() const { return Copy(rows); }
};
// How sessions run.
struct SessionForm {
    std::function<std::unique_ptr<EditableSimulator>(const Setup&)> make;
    std::size_t history = 0;  // of steps in memory [bytes]
    Codec codec = Codec::automatic;
    bool large = false;  // no states in double precision
};
std::unique_ptr<EditableSimulator> one_thread(Setup setup)
{
    setup.threads = 1;
    return cpu_solver(setup);
}
struct SavedFile {
    std::string path;
    Reference reference;
    Clay clay;
};

struct Counts {
    std::atomic<long> operations = 0, frames = 0, refused = 0, restored = 0, evicted = 0,
                      opened = 0, recovered = 0, replayed = 0, hashes = 0, touched = 0, steps = 0;
};

// The folder of working logs.
class LogFolder {
  public:
    LogFolder()
    {
        if (const char* set = std::getenv("XDG_STATE_HOME")) before = set;
        setenv("XDG_STATE_HOME", folder.path().c_str(), 1);
    }
    ~LogFolder()
    {
        if (before.empty())
            unsetenv("XDG_STATE_HOME");
        else
            setenv("XDG_STATE_HOME", before.c_str(), 1);
    }

  private:
    Folder folder;
    std::string before;
};

class RandomSession {
  public:
    RandomSession(std::uint64_t seed, const std::string& scene_file, const std::string& own_folder,
                  Counts& all, const SessionForm& by)
        : r(seed), folder(own_folder), counts(all), form(by), scene(load_live_scene(scene_file))
    {
        fs::create_directories(folder);
        LiveOptions options;
        options.make_solver = [this](const Setup& setup) {
            auto made = form.make(setup);
            simulator = made.get();
            return made;
        };
        options.stepped = true, options.recorded = false;
        options.logs = true, options.protects = true;
        options.history = form.history, options.codec = form.codec;
        options.published = [this] { frame_published(); };
        session = std::make_unique<LiveSession>(scene, options);
        session->wait_for_commands();
        observed = session.get();
        now = clay();
        add_first_step();
        first = *now.document->scene;
    }
    ~RandomSession()
    {
        session.reset();
        std::error_code none;
        fs::remove_all(folder, none);
        for (const std::string& log : logs) fs::remove(log, none);
    }

    void run(long operations)
    {
        for (long i = 0; i < operations && !failed(); ++i) {
            SCOPED_TRACE(testing::Message() << "operation " << i);
            operate();
            ++counts.operations;
        }
        if (!failed()) replay();
    }

  private:
    bool failed() const { return testing::Test::HasFailure(); }

    // On the session's thread.
    void frame_published()
    {
        const LiveSession* of = observed;
        if (!of) return;
        const auto state = of->state();
        if (state->history == seen_history && state->frame.number == seen_frame) return;
        seen_history = state->history, seen_frame = state->frame.number;
        if (seen_frame == 0 || !state->failure.empty()) return;
        counts.touched += state->frame.stats.touched != 0;
        shots.push_back({rows_now(), steps_now(), state->document});
    }
    Rows rows_now() const
    {
        return std::make_shared<const ClayRows>(simulator->rows(*simulator->snapshot()));
    }
    Quantisation steps_now() const { return quantisation_of(simulator->config()); }
    // What a step has that is captured now. The clay itself is not rounded by a capture.
    Copy captured(const Clay& at) const
    {
        const bool lossless =
            form.codec == Codec::lossless ||
            (form.codec == Codec::automatic && at.rows->count <= most_lossless_particles);
        return lossless ? at.copy()
                        : Copy(std::make_shared<const ClayRows>(quantised(*at.rows, at.steps)));
    }
    Clay clay()
    {
        Clay found;
        session->inspect_solver([&](const Simulator&) {
            found.rows = rows_now(), found.steps = steps_now();
            if (!form.large) found.state = std::make_shared<const SavedState>(simulator->save());
        });
        found.document = session->state()->document;
        return found;
    }
    void add_first_step()
    {
        const auto steps = session->state()->steps;
        ASSERT_TRUE(steps);
        ASSERT_EQ(steps->size(), 1u);
        reference = {};
        reference.steps[0] = {0, steps->at(0).label, now.document, now.copy(), false};
    }

    // The listed steps before the operation.
    std::vector<StepInfo> listed() const
    {
        const auto steps = session->state()->steps;
        return steps ? *steps : std::vector<StepInfo>{};
    }
    static const StepInfo* find(const std::vector<StepInfo>& in, StepId id)
    {
        const auto found = std::ranges::find(in, id, &StepInfo::id);
        return found == in.end() ? nullptr : &*found;
    }

    // Takes the events since the last call. `before`, `after`: around an operation.
    void follow(const Clay& before, const Clay& after)
    {
        const SessionLog log = session->session_log();
        Clay at = before;
        std::size_t frame = 0;
        for (; events < log.events.size(); ++events) {
            const SessionEvent& event = log.events[events];
            if (std::holds_alternative<FrameEvent>(event)) {
                ASSERT_LT(frame, shots.size());
                at = shots[frame++];
                ++counts.frames;
            } else if (std::holds_alternative<CommandEvent>(event) ||
                       std::holds_alternative<RunBegun>(event)) {
                at = after;
            } else if (const auto* begun = std::get_if<StepBegun>(&event)) {
                EXPECT_GT(begun->id, reference.last) << "an id repeats";
                EXPECT_EQ(begun->parent, reference.current);
                EXPECT_TRUE(reference.steps.at(reference.current).rows) << "two are open";
                reference.steps[begun->id] = {begun->parent, begun->label, at.document, {}, false};
                reference.current = reference.last = begun->id;
                ++counts.steps;
            } else if (const auto* taken = std::get_if<StepCaptured>(&event)) {
                EXPECT_EQ(taken->id, reference.current);
                ReferenceStep& step = reference.steps.at(taken->id);
                EXPECT_FALSE(step.rows) << "it was captured twice";
                step.rows = taken->unchanged ? reference.steps.at(step.parent).rows : captured(at);
                step.document = at.document, step.unchanged = taken->unchanged;
            } else if (const auto* restored = std::get_if<StepRestored>(&event)) {
                ASSERT_TRUE(reference.steps.contains(restored->id));
                ASSERT_TRUE(reference.steps.at(restored->id).rows) << "it is open";
                reference.current = restored->id;
            }
        }
        EXPECT_EQ(frame, shots.size());
        shots.clear();
        now = after;
    }

    void check_list()
    {
        const auto state = session->state();
        ASSERT_EQ(state->failure, "");
        const std::vector<StepInfo> steps = listed();
        int current = 0;
        for (std::size_t i = 0; i < steps.size(); ++i) {
            const StepInfo& info = steps[i];
            EXPECT_TRUE(i == 0 || info.id > steps[i - 1].id);
            const auto found = reference.steps.find(info.id);
            ASSERT_NE(found, reference.steps.end()) << "step " << info.id;
            EXPECT_EQ(info.parent, found->second.parent);
            EXPECT_EQ(info.label, found->second.label);
            EXPECT_EQ(info.current, info.id == reference.current);
            current += info.current;
        }
        EXPECT_EQ(current, 1);
        counts.evicted =
            std::max<long>(counts.evicted, long(reference.steps.size()) - long(steps.size()));
    }

    // --- operations

    // An operation that is no frame: its clay, and what it did to the steps.
    struct Answer {
        bool refused = false;
        std::string why;
    };
    Answer apply(const Command& command, unsigned drag = 0)
    {
        SCOPED_TRACE(row_of(command).name);
        const Clay before = now;
        const std::vector<StepInfo> steps = listed();
        const auto state_before = session->state();
        const long serial = session->send(command, Origin::window, drag);
        session->wait_for_commands();
        const auto state = session->state();
        EXPECT_EQ(state->answered, serial);
        const Clay after = clay();
        const Answer answer{state->refused != state_before->refused, state->refusal};
        follow(before, after);
        for (AppliedCommand& one : session->take_applied()) applied = std::move(one.issued.command);
        if (!answer.refused) return answer;
        ++counts.refused;
        EXPECT_EQ(state->refused, state_before->refused + 1);
        EXPECT_NE(answer.why, "");
        EXPECT_TRUE(equal(*after.document, *before.document)) << answer.why;
        EXPECT_TRUE(same_rows(*after.rows, *before.rows)) << answer.why;
        Difference changed;
        if (after.state && before.state) changed.states(*after.state, *before.state);
        EXPECT_EQ(changed.first, "") << answer.why;
        const std::vector<StepInfo> steps_after = listed();
        EXPECT_TRUE(std::ranges::equal(steps, steps_after, {}, &StepInfo::id, &StepInfo::id))
            << answer.why;
        return answer;
    }

    // The user's hands go on all the time, as a tracker has them.
    void advance(int frames)
    {
        const Clay before = now;
        for (int i = 1; i <= frames; ++i) push(double(ticks + i) / rate);
        ticks += frames;
        session->advance_to(double(ticks) / rate);
        follow(before, clay());
    }

    void push(double time)
    {
        constexpr double fastest = 0.01;  // [m] a frame: a hand that leaps is another one
        const std::vector<HandFrame>& recording = scene->recording->frames;
        const auto there = std::ptrdiff_t(recording.size()) - 1;
        HandFrame frame = recording[std::size_t(there - std::abs(pose++ % (2 * there) - there))];
        frame.time = time;
        const Vec3<double> left_to_go = goal - shift;
        const double far = length(left_to_go);
        shift = shift + std::min(1.0, fastest / std::max(far, 1e-9)) * left_to_go;
        for (Hand& hand : frame.hand) {
            hand.tracked = hand.tracked && tracked;
            for (Joint<float>& j : hand.joints) j.p = j.p + cast<float>(shift);
        }
        session->push(frame);
    }

    // The hands go to another object; sometimes they are lost, and found again.
    void gesture()
    {
        const auto& objects = now.document->objects;
        const HandSettings& hands = *now.document->hands;
        goal = {r.in(-0.05, 0.05), r.in(-0.05, 0.05), r.in(-0.05, 0.05)};
        if (!objects.empty()) goal = goal + (1 / hands.zoom) * (r.of(objects)->pose.p - hands.at);
        tracked = !r.one_in(20);
        advance(4 + r.below(9));
    }

    Command edit()
    {
        const Document& d = *now.document;
        Drawing by{0, &d};
        if (r.one_in(5)) {  // one that is refused, or changes nothing
            by.wild = 100, by.unknown = 100;
            while (true) {
                const Command c = random_command(r, by);
                if (row_of(c).receiver == Receiver::document &&
                    !std::holds_alternative<AddObject>(c) && !std::holds_alternative<SetLattice>(c))
                    return c;
            }
        }
        const ObjectId object = d.objects.empty() ? ObjectId{1} : r.of(d.objects)->id;
        const double dx = 0.03;
        const Vec3<double> in{r.in(0, dx), r.in(0, dx), r.in(0, dx)};
        const Vec3<double> place{r.in(0.15, 0.33), r.in(0.15, 0.33), r.in(0.15, 0.33)};
        const Vec3<double> other_place{r.in(0.15, 0.33), r.in(0.15, 0.33), r.in(0.15, 0.33)};
        MaterialSpec m = r.of(material_specs());
        m.density = r.in(500, 2000);
        if (m.plasticity != Plasticity::fluid) m.young = r.in(2e4, 2e5);
        const ObjectId other = d.objects.empty() ? ObjectId{1} : r.of(d.objects)->id;
        switch (r.below(22)) {
            case 0:
                return SetMaterial{object, m};
            case 1:
                return SetCategory{object, r.below(3)};
            case 2:
                return SetGravity{{r.in(-9, 9), r.in(-9, 9), r.one_in(2) ? -0.0 : 0.0}};
            case 3:
                return SetWalls{first.walls.min + in, first.walls.max - in,
                                r.of(contact_modes).second, r.in(0, 1)};
            case 4: {
                auto hands = random_fields<SetHands>(r, by);
                hands.zoom.reset(), hands.at.reset();
                return hands;
            }
            case 5:
                return SetSurface{8 + r.below(10)};
            case 6:
                return SetFlags{object, r.one_in(6), r.one_in(2)};
            case 7:
                if (r.one_in(2)) return SetColour{{object}, Vec3<double>{r.in(0, 1), 0.5, 0}};
                return Rename{object, r.one_in(2) ? "a" : "b"};
            case 8:
            case 9: {
                if (d.objects.size() > 3) return RemoveObjects{{object}};
                SceneObject o;
                o.source.shape =
                    r.of(std::vector{ShapeKind::sphere, ShapeKind::box, ShapeKind::cylinder});
                o.source.size = {0.09, 0.09, 0.09};
                o.material = m, o.category = r.below(3);
                o.pose = {random_rotation(r), place};
                if (r.one_in(4)) o.source.velocity = {0, r.in(-1, 1), 0};
                return AddObject{o};
            }
            case 12:
                if (d.objects.size() > 3) return RemoveObjects{{object}};
                return CopyObjects{{object}, place - Vec3<double>{0.24, 0.2, 0.24}, {}, {}};
            case 20:
                return MoveObjects{{object},
                                   Vec3<double>{r.in(-0.05, 0.05), r.in(-0.05, 0.05), 0},
                                   r.one_in(2) ? std::optional(random_rotation(r)) : std::nullopt,
                                   {}};
            case 21:
                return ResetObjects{{object}};
            case 13:
                return ScaleObjects{{object}, r.in(0.7, 1.2)};
            case 17: {
                if (d.objects.size() > 4) return RemoveObjects{{object}};
                SourceBegin begins;
                begins.name = "s", begins.section = r.of(section_kinds).second;
                begins.diameter = 0.1, begins.at = place;
                if (begins.section == SectionKind::outline) begins.outline = random_outline(r);
                return begins;
            }
            case 18:
            case 19: {
                const auto nozzle =
                    std::ranges::find_if(d.objects, [](const auto& o) { return is_open(*o); });
                const ObjectId id = nozzle == d.objects.end() ? object : (*nozzle)->id;
                if (r.one_in(4)) return SourceEnd{id};
                return SourceMove{id, place, r.one_in(2) ? std::optional(place) : std::nullopt};
            }
            case 14:
                return MergeObjects{{object, other}, {}};
            case 15:
                return SplitObject{object, {}, true, {}, {}};
            case 16:
                if (d.objects.size() > 4) return MergeObjects{{object, other}, "c"};
                return SplitObject{object, SplitPlane{place, place - other_place}, {}, {}, {}};
            case 10:
                if (r.one_in(2)) return RemoveObjects{{object}};
                [[fallthrough]];
            default:
                return PlaceObject{object, place, random_rotation(r)};
        }
    }

    // Commands of the document do what reduce() says.
    void change()
    {
        const DocumentPtr before = now.document;
        const Answer answer = apply(edit(), r.one_in(3) ? 1 + unsigned(r.below(2)) : 0);
        if (answer.refused) return;
        IdSource ids;
        EXPECT_TRUE(equal(*after(before, applied, ids), *now.document)) << row_of(applied).name;
    }

    void carry()
    {
        const auto& objects = now.document->objects;
        const ObjectId object = objects.empty() ? ObjectId{1} : r.of(objects)->id;
        apply(Carry{{object}, r.one_in(2) ? left : right, r.below(3) > 0});
    }

    // Whether steps on the way between these have changed clay.
    bool same_clay(StepId one, StepId other) const
    {
        std::vector<StepId> a{one}, b{other};
        for (std::vector<StepId>* way : {&a, &b})
            while (way->back() != reference.steps.at(way->back()).parent)
                way->push_back(reference.steps.at(way->back()).parent);
        while (!a.empty() && !b.empty() && a.back() == b.back()) a.pop_back(), b.pop_back();
        const auto unchanged = [&](StepId id) { return reference.steps.at(id).unchanged; };
        return std::ranges::all_of(a, unchanged) && std::ranges::all_of(b, unchanged);
    }
    DocumentPtr with_hands_and_surface_of(const Document& step, const Document& other) const
    {
        auto to = std::make_shared<Document>(step);
        to->hands = other.hands;
        SceneSettings settings = *to->scene;
        settings.surface_nodes = other.scene->surface_nodes;
        to->scene = std::make_shared<const SceneSettings>(settings);
        return to;
    }

    std::string steps_like(const Copy& clay) const
    {
        std::string found;
        for (const auto& [id, step] : reference.steps)
            if (step.rows && same(clay, step.rows)) found += std::to_string(id) + " ";
        return found;
    }

    // `to`: the step that the command must lead to; none: it must be refused.
    void restore(const Command& command, std::optional<StepId> to)
    {
        const Clay before = now;
        const StepId from = reference.current;
        const Answer answer = apply(command);
        EXPECT_EQ(answer.refused, !to) << answer.why << (to ? *to : 0);
        if (answer.refused || !to) return;
        ++counts.restored;
        EXPECT_EQ(reference.current, *to);
        const ReferenceStep& step = reference.steps.at(*to);
        const bool stays = *to != from && same_clay(from, *to);
        EXPECT_TRUE(same(now.copy(), stays ? before.copy() : step.rows))
            << "step " << *to << " from " << from << (stays ? ", of the same clay" : "")
            << "; it has the clay of: " << steps_like(now.copy())
            << (same(now.copy(), before.copy()) ? "and that of before" : "");
        EXPECT_TRUE(
            equal(*now.document, *with_hands_and_surface_of(*step.document, *before.document)))
            << "step " << *to << " from " << from;
    }
    void undo()
    {
        const std::vector<StepInfo> steps = listed();
        const StepId parent = reference.steps.at(reference.current).parent;
        const bool there = parent != reference.current && find(steps, parent);
        restore(Undo{}, there ? std::optional(parent) : std::nullopt);
    }
    void redo()
    {
        std::optional<StepId> to;
        for (const StepInfo& info : listed())
            if (info.on_line && info.parent == reference.current && info.id != reference.current)
                to = info.id;
        restore(Redo{}, to);
    }
    void go_to()
    {
        const int id = r.one_in(20) ? -1 : r.below(int(reference.last) + 3);
        const bool there = find(listed(), StepId(id));
        restore(GoTo{id}, there ? std::optional(StepId(id)) : std::nullopt);
    }

    void reset()
    {
        const Answer answer = apply(Reset{});
        EXPECT_FALSE(answer.refused) << answer.why;
        const ReferenceStep& begun = reference.steps.at(reference.current);
        EXPECT_EQ(begun.label, "Reset");
        ASSERT_TRUE(begun.rows);
        EXPECT_TRUE(same(begun.rows, captured(now)));
        EXPECT_TRUE(equal(*now.document, document_of(scene->scene)));
    }

    void save()
    {
        const std::string to = folder + "/" + std::to_string(r.below(3)) + ".knead";
        if (r.one_in(10)) {
            EXPECT_TRUE(apply(Save{folder + "/no folder/a.knead", {}}).refused ||
                        waited_for_refusal());
            return;
        }
        std::error_code none;
        fs::remove(to, none);
        if (r.one_in(4)) return save_and_reset(to);
        const Answer answer = apply(Save{to, {}});
        ASSERT_FALSE(answer.refused) << answer.why;
        ASSERT_TRUE(waited([&] { return fs::exists(to) && session->state()->saved_as == to; }));
        std::erase_if(files, [&](const SavedFile& one) { return one.path == to; });
        files.push_back({to, reference, now});
        const SessionFile file(to);
        EXPECT_NE(file.final_state(), 0u);
        const Reference found = expect_steps(file);
        EXPECT_EQ(found.steps.size(), reference.steps.size()) << "also those that were evicted";
        EXPECT_EQ(found.current, reference.current);
    }
    // The file has what was there when the command came.
    void save_and_reset(const std::string& to)
    {
        const Clay before = now;
        session->send(Save{to, {}}), session->send(Reset{});
        session->wait_for_commands();
        follow(before, clay());
        ASSERT_TRUE(waited([&] { return fs::exists(to) && session->state()->saved_as == to; }));
        std::erase_if(files, [&](const SavedFile& one) { return one.path == to; });
        const SessionFile file(to);
        expect_steps(file);
        const StoredState state = file.state(file.final_state());
        EXPECT_TRUE(equal(*state.document, *before.document));
        EXPECT_TRUE(same_rows(rows_of(state.state.contents.particles), *before.rows));
    }
    // Changes neither clay nor document nor steps.
    void write_export()
    {
        Export command;
        command.file = folder + (r.one_in(4) ? "/no folder/a.obj" : "/a.obj");
        if (const auto& objects = now.document->objects; r.one_in(2) && !objects.empty())
            command.objects = {r.of(objects)->id};
        const Clay before = now;
        const auto state = session->state();
        const std::size_t steps = reference.steps.size();
        const Answer answer = apply(command);
        EXPECT_EQ(reference.steps.size(), steps);
        EXPECT_TRUE(same_rows(*now.rows, *before.rows));
        EXPECT_TRUE(equal(*now.document, *before.document));
        EXPECT_EQ(session->state()->unsaved, state->unsaved);
        if (answer.refused) return;
        EXPECT_TRUE(waited([&] {
            const auto later = session->state();
            return later->exports > state->exports || later->refused > state->refused;
        }));
    }
    static ClayRows rows_of(const std::vector<Particle<double>>& particles)
    {
        ClayRows rows = empty_rows(particles.size());
        for (std::size_t i = 0; i < particles.size(); ++i)
            set_particle(rows, i, cast<float>(particles[i]));
        return rows;
    }
    bool waited(const std::function<bool()>& is) const
    {
        for (int i = 0; i < 20000 && !is(); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return is();
    }
    bool waited_for_refusal()
    {
        const int refused = session->state()->refused;
        return waited([&] { return session->state()->refused != refused; }) ||
               !session->state()->refusal.empty();
    }

    // All steps of a file are those of the reference. Returns them, as a reference.
    Reference expect_steps(const SessionFile& file)
    {
        Reference found;
        History all(std::size_t(1) << 40);
        file.read_history(all, file.current());
        found.current = all.current().id;
        for (const StepInfo& info : all.list()) {
            const auto known = reference.steps.find(info.id);
            if (known == reference.steps.end() || !known->second.rows) {
                ADD_FAILURE() << "step " << info.id << " was not captured";
                continue;
            }
            const ReferenceStep& step = known->second;
            EXPECT_EQ(info.parent, step.parent);
            EXPECT_EQ(info.label, step.label);
            EXPECT_TRUE(equal(*all.find(info.id)->document, *step.document)) << info.id;
            const Rows rows = all.rows_of(info.id);
            EXPECT_TRUE(same(Copy(rows), step.rows)) << info.id;
            if (form.large) all.go_to(info.id, rows);  // from there it is not far to the next
            found.steps.insert(*known);
            found.last = info.id;
        }
        return found;
    }

    void open_file(const std::string& file, const Reference& with)
    {
        logs.insert(session->state()->log.file);
        const long serial = session->send(Open{file, {}, {}});
        session->wait_for_commands();
        const auto state = session->state();
        EXPECT_EQ(state->answered, serial);
        ASSERT_EQ(state->failure, "");
        reference = with;
        const Clay opened = clay();
        events = 0, shots.clear();
        follow(opened, opened);
        session->take_applied();
    }

    void open()
    {
        if (r.one_in(8) || files.empty()) {
            const std::string bad = folder + "/none.knead";
            if (r.one_in(2)) std::ofstream(bad) << "knead.session";
            EXPECT_TRUE(apply(Open{bad, {}, {}}).refused);
            return;
        }
        const SavedFile from = r.of(files);
        const int refused = session->state()->refused;
        open_file(from.path, from.reference);
        EXPECT_EQ(session->state()->refused, refused) << session->state()->refusal;
        EXPECT_EQ(reference.current, from.reference.current);
        EXPECT_TRUE(same_rows(*now.rows, *from.clay.rows));
        EXPECT_TRUE(equal(*now.document, *from.clay.document));
        EXPECT_EQ(session->state()->saved_as, from.path);
        ++counts.opened;
    }

    // The log as a process that is killed now leaves it.
    void recover()
    {
        const std::string log = session->state()->log.file;
        ASSERT_NE(log, "");
        if (r.one_in(8)) {
            ASSERT_TRUE(waited([&] {
                session->inspect_solver([](const Simulator&) {});  // publishes
                return session->state()->log.waiting == 0;
            }));
        }
        const std::string copy =
            (fs::path(log).parent_path() /
             (fs::path(folder).filename().string() + "-" + std::to_string(++copies) + log_ending))
                .string();
        fs::copy_file(log, copy);
        Reference found;
        std::optional<StoredState> state;
        {
            std::optional<SessionFile> file;
            try {
                file.emplace(copy);
            } catch (const InputError&) {  // nothing was committed yet
                std::error_code none;
                fs::remove(copy, none);
                return;
            }
            if (file->steps() == 0) return;
            found = expect_steps(*file);
            if (file->final_state()) state = file->state(file->final_state());
            // Numbers of steps that were begun are not used again, though they are lost.
            file->each_event([&](const SessionEvent& event) {
                if (const auto* begun = std::get_if<StepBegun>(&event))
                    found.last = std::max(found.last, begun->id);
                return true;
            });
        }
        logs.insert(copy);
        open_file(copy, found);
        const ReferenceStep& at = reference.steps.at(reference.current);
        EXPECT_EQ(reference.current, found.current);
        if (state) {
            EXPECT_TRUE(same_rows(*now.rows, rows_of(state->state.contents.particles)));
            EXPECT_TRUE(equal(*now.document, *state->document));
        } else {
            EXPECT_TRUE(same(now.copy(), at.rows)) << "step " << reference.current;
            EXPECT_TRUE(
                equal(*with_hands_and_surface_of(*at.document, *now.document), *now.document));
        }
        ++counts.recovered;
    }

    void operate()
    {
        const int kind = r.below(100);
        if (kind < 20)
            advance(1 + r.below(2));
        else if (kind < 22)
            advance(15 + r.below(20));
        else if (kind < 36)
            gesture();
        else if (kind < 64)
            change();
        else if (kind < 68)
            carry();
        else if (kind < 78)
            undo();
        else if (kind < 86)
            redo();
        else if (kind < 95)
            go_to();
        else if (kind < 96)
            reset();
        else if (kind < 98 && r.one_in(3))
            write_export();
        else if (kind < 98)
            save();
        else if (kind < 99)
            open();
        else
            recover();
        if (!failed()) check_list();
    }

    // The working log gives the clay of the session again.
    void replay()
    {
        apply(SetGravity{{0, r.in(-9, -1), 0}});  // a log without unsaved steps is not completed
        const std::string log = session->state()->log.file, kept = folder + "/kept.log";
        ASSERT_NE(log, "");
        fs::create_hard_link(log, kept);
        SavedState live;
        session->inspect_solver([&](const Simulator&) { live = simulator->save(); });
        observed = nullptr;
        session.reset();
        const SessionFile file(kept);
        ReplayOptions options;
        options.make_solver = form.make;
        options.stepped = true;
        options.stored_state = [&](std::uint64_t id) { return file.state(id); };
        options.read_history = [&](History& past) { file.read_history(past, 0); };
        options.compared = [&](const ReplayedHash& hash) {
            EXPECT_TRUE(hash.equal) << "frame " << hash.frame;
            ++counts.hashes;
        };
        SessionReplay again(live_scene_of(file.scene()), options);
        file.each_event([&](const SessionEvent& event) {
            if (const HashEvent* hash = std::get_if<HashEvent>(&event)) again.expect(*hash);
            return true;
        });
        try {
            file.each_event([&](const SessionEvent& event) { return again.add(event); });
            Difference of;
            of.states(again.simulator().editable()->save(), live);
            EXPECT_EQ(of.first, "") << "after frame " << again.frames();
        } catch (const std::exception& e) {
            ADD_FAILURE() << "after frame " << again.frames() << ": " << e.what();
        }
        ++counts.replayed;
    }

    Random r;
    const std::string folder;
    Counts& counts;
    const SessionForm form;
    const std::shared_ptr<const LiveScene> scene;
    EditableSimulator* simulator = nullptr;  // of the session
    std::atomic<const LiveSession*> observed = nullptr;
    int seen_history = 0, seen_frame = 0;
    std::vector<Clay> shots;  // after each frame of the operation
    std::unique_ptr<LiveSession> session;
    Reference reference;
    Clay now;
    SceneSettings first;
    std::size_t events = 0;        // that were followed
    long ticks = 0;                // of the session's clock
    std::ptrdiff_t pose = 0;       // of the recorded hands
    Vec3<double> shift{}, goal{};  // of the hands, in the tracker's frame [m]
    bool tracked = true;
    Command applied;
    std::vector<SavedFile> files;
    std::set<std::string> logs;
    int copies = 0;
};

std::unique_ptr<EditableSimulator> deterministic_gpu(Setup setup)
{
    setup.deterministic = true;
    return gpu_solver(setup, 0);
}

// Operations in sessions of at most `in_one`, on as many threads.
void run_sessions(const std::string& scene, const SessionForm& form, long in_all, long in_one,
                  int threads)
{
    const LogFolder logs;
    Folder own;
    std::ofstream(own / "scene.json") << scene;
    if (const char* stated = std::getenv("KNEAD_LONG_OPERATIONS")) in_all = std::atol(stated);
    const char* given = std::getenv("KNEAD_SEED");
    const std::uint64_t seed = given                       ? std::strtoull(given, nullptr, 10)
                               : std::getenv("KNEAD_LONG") ? std::random_device{}()
                                                           : 59;
    Counts counts;
    std::atomic<long> next = 0;
    const auto work = [&] {
        while (!testing::Test::HasFailure()) {
            const long i = next++;
            if (i * in_one >= in_all) return;
            SCOPED_TRACE(testing::Message() << "seed " << seed + std::uint64_t(i));
            try {
                RandomSession one(seed + std::uint64_t(i), own / "scene.json",
                                  own / ("s" + std::to_string(i)), counts, form);
                one.run(std::min(in_one, in_all - i * in_one));
            } catch (const std::exception& e) {
                ADD_FAILURE() << e.what();
            }
        }
    };
    std::vector<std::thread> others;
    for (int i = 1; i < threads; ++i) others.emplace_back(work);
    work();
    for (std::thread& one : others) one.join();
    EXPECT_GT(counts.restored, counts.operations / 10);
    EXPECT_GT(counts.refused, counts.operations / 40);
    // How many depends on the load: a slow machine has fewer frames while a hand is at the clay.
    EXPECT_GT(counts.touched, counts.frames / 100) << "hands press clay";
    if (in_all >= 600) {
        EXPECT_GT(counts.evicted, 0);
        EXPECT_GT(counts.opened, 0);
        EXPECT_GT(counts.recovered, 0);
    }
    std::printf(
        "%ld operations, %ld frames, %ld steps, %ld restored, %ld refused, %ld opened, "
        "%ld recovered, %ld replayed, %ld hashes, %ld frames of contact\n",
        counts.operations.load(), counts.frames.load(), counts.steps.load(), counts.restored.load(),
        counts.refused.load(), counts.opened.load(), counts.recovered.load(),
        counts.replayed.load(), counts.hashes.load(), counts.touched.load());
}

constexpr std::size_t ten_steps = std::size_t(1) << 19;  // of two_objects: most are evicted

TEST(SessionModel, HasTheStepsOfAReferenceThatKeepsWholeCopies)
{
    run_sessions(two_objects, {one_thread, ten_steps}, repeats(sanitized ? 100 : 600, 1000000), 300,
                 2);
}

TEST(SessionModel, HasTheStepsOfTheReferenceRoundedByTheQuantisedCodec)
{
    run_sessions(two_objects, {one_thread, ten_steps / 4, Codec::quantised},
                 repeats(sanitized ? 60 : 240, 100000), 120, 2);
}

// About 1 M particles, deterministic: a replay has the same bits.
TEST(SessionModel, HasTheStepsOfTheReferenceOnAGpu)
{
    if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    const bool all = std::getenv("KNEAD_LONG") != nullptr;
    std::string scene = two_objects;
    const std::string coarse = R"("cells": 16)";
    scene.replace(scene.find(coarse), coarse.size(), all ? R"("cells": 152)" : R"("cells": 72)");
    run_sessions(scene,
                 {deterministic_gpu, std::size_t(1) << (all ? 27 : 24), Codec::automatic, true},
                 all ? 2000 : 60, all ? 125 : 60, all ? 8 : 1);
}

}  // namespace
}  // namespace knead
