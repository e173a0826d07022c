// The queue of commands: several senders, one reader of states, one who takes what was applied.
// Also run under the thread sanitizer.
#include <atomic>
#include <future>
#include <map>
#include <random>
#include <thread>

#include "host/scene/presets.h"
#include "tests/live/live_slow.h"
#include "tests/sanitized.h"

namespace knead {
namespace {

// Of each sender, the numbers of its marks.
using Sent = std::map<std::string, std::vector<int>>;
void add_marks(Sent& to, const std::vector<AppliedCommand>& applied)
{
    for (const AppliedCommand& one : applied) {
        const Mark* mark = std::get_if<Mark>(&one.issued.command);
        if (!mark) continue;
        const std::size_t end = mark->text.find(' ');
        to[mark->text.substr(0, end)].push_back(std::stoi(mark->text.substr(end)));
    }
}

// Sends marks among other commands, and hands, until `count` or `stop`.
struct Sender {
    LiveSession& session;
    const std::atomic<bool>& stop;
    std::string name;
    int count;
    int sent = 0;

    void operator()()
    {
        std::minstd_rand random{unsigned(name[0])};
        for (int i = 0; i < count && !stop; ++i) {
            while (session.send(Mark{name + " " + std::to_string(i)}, Origin(random() % 4)) == 0)
                std::this_thread::yield();  // the queue was full
            ++sent;
            const auto other = random() % 24;
            if (other == 0) session.send(Pause{random() % 2 == 0});
            if (other == 1) session.send(Advance{int(1 + random() % 3)});
            if (other == 2) session.send(Rename{ObjectId{1}, name});
            if (other == 3) session.send(SetSurface{int(8 + random() % 20)}, Origin::window, 7);
            if (other == 4) session.send(SetCategory{ObjectId{9}, 1});  // is refused
            if (other == 5 && i % 8 == 0) session.send(Reset{});
            if (other == 6) session.push({});
            if (other == 7) session.wait_for_commands();
        }
    }
};

TEST_F(Live, CommandsOfFourSendersAreAppliedOnceAndInTheOrderOfEach)
{
    prepare = [](Slow& s) { s.substep = 0; };
    LiveSession session(scene, options);
    std::atomic<bool> stop = false, over = false;
    const int count = sanitized ? 300 : 2000;
    std::vector<Sender> senders;
    for (const char* name : {"a", "b", "c", "d"}) senders.push_back({session, stop, name, count});
    Sent taken;
    long serial = 0, applied = 0;
    std::thread taker([&] {
        for (bool last = false; !last; std::this_thread::yield()) {
            last = over;
            const std::vector<AppliedCommand> all = session.take_applied();
            add_marks(taken, all);
            applied += long(all.size());
            int history = 0;
            for (const AppliedCommand& one : all) {
                EXPECT_GT(one.issued.serial, serial);
                EXPECT_GE(one.history, history);
                serial = one.issued.serial, history = one.history;
            }
        }
    });
    std::thread reader([&] {
        long version = 0, answered = 0;
        while (!over) {
            const auto state = session.state();
            EXPECT_GE(state->version, version);
            EXPECT_GE(state->answered, answered);
            if (state->document) {
                EXPECT_FALSE(state->document->objects.empty());
            }
            version = state->version, answered = state->answered;
            clock = clock + 1e-4;
        }
    });
    std::vector<std::thread> threads;
    for (Sender& sender : senders) threads.emplace_back([&] { sender(); });
    for (std::thread& thread : threads) thread.join();
    session.wait_for_commands();
    EXPECT_EQ(session.state()->failure, "");
    over = true;
    taker.join(), reader.join();
    EXPECT_GT(applied, 4L * count);
    for (const Sender& sender : senders) {
        ASSERT_EQ(int(taken[sender.name].size()), count) << sender.name;
        for (int i = 0; i < count; ++i) ASSERT_EQ(taken[sender.name][std::size_t(i)], i);
    }
}

// What was applied before the end is a beginning of what each has sent.
TEST_F(Live, ASessionMayEndWhileCommandsWait)
{
    std::minstd_rand random(3);
    for (int round = 0; round < (sanitized ? 10 : 60); ++round) {
        std::atomic<bool> stop = false;
        Sent taken;
        std::vector<int> sent;
        {
            LiveSession session(scene, options);
            std::vector<Sender> senders;
            for (const char* name : {"a", "b", "c", "d"})
                senders.push_back({session, stop, name, 100000});
            std::vector<std::thread> threads;
            for (Sender& sender : senders) threads.emplace_back([&] { sender(); });
            const auto end =
                std::chrono::steady_clock::now() + std::chrono::microseconds(random() % 5000);
            while (std::chrono::steady_clock::now() < end) {
                add_marks(taken, session.take_applied());
                clock = clock + 1e-3;
            }
            stop = true;
            for (std::thread& thread : threads) thread.join();
            add_marks(taken, session.take_applied());
            for (const Sender& sender : senders) sent.push_back(sender.sent);
        }
        for (int k = 0; k < 4; ++k) {
            const std::vector<int>& got = taken[std::string(1, char('a' + k))];
            ASSERT_LE(int(got.size()), sent[std::size_t(k)]);
            for (int i = 0; i < int(got.size()); ++i) ASSERT_EQ(got[std::size_t(i)], i);
        }
    }
}

// Keeps the session's thread busy while commands are queued.
class Blocked {
  public:
    explicit Blocked(LiveSession& session)
        : thread([this, &session] {
              session.inspect_solver([this](const Simulator&) {
                  begun.set_value();
                  released.get_future().wait();
              });
          })
    {
        begun.get_future().wait();
    }
    ~Blocked()
    {
        released.set_value();
        thread.join();
    }

  private:
    std::promise<void> begun, released;
    std::thread thread;
};

std::vector<Command> taken_from(LiveSession& session)
{
    session.wait_for_commands();
    std::vector<Command> all;
    for (AppliedCommand& one : session.take_applied()) all.push_back(std::move(one.issued.command));
    return all;
}

TEST_F(Live, OfADragThatWaitsOnlyTheLastValueIsSet)
{
    options.stepped = true;
    options.make_solver = cpu_solver;
    LiveSession session(scene, options);
    session.wait_for_commands();
    {
        const Blocked blocked(session);
        for (int i = 0; i < 50; ++i)
            session.send(SetGravity{{0, double(-i), 0}}, Origin::window, 3);
        session.send(Mark{"between"});
        for (int i = 0; i < 50; ++i) session.send(SetGravity{{1, 0, 0}}, Origin::headset, 3);
        session.send(SetGravity{{0, 2, 0}});  // of no drag
        session.send(SetGravity{{0, 3, 0}});
    }
    const std::vector<Command> applied = taken_from(session);
    ASSERT_EQ(applied.size(), 5u);
    EXPECT_EQ(std::get<SetGravity>(applied[0]).gravity.y, -49);
    EXPECT_EQ(std::get<Mark>(applied[1]).text, "between");
    EXPECT_EQ(std::get<SetGravity>(applied[2]).gravity.x, 1);
    EXPECT_EQ(session.state()->document->scene->gravity.y, 3);
    EXPECT_EQ(session.state()->answered, 103);
}

TEST_F(Live, OfADragNothingIsLostThatIsNotSetAgain)
{
    options.stepped = true;
    options.make_solver = cpu_solver;
    LiveSession session(scene, options);
    session.wait_for_commands();
    const WallOptions walls = session.state()->document->scene->walls;
    {
        const Blocked blocked(session);
        const auto send = [&](const Command& command) { session.send(command, Origin::window, 4); };
        send(SetWalls{{}, {}, ContactMode::slip, 0.1});
        send(SetWalls{{}, {}, {}, 0.2});
        send(SetWalls{{}, {}, {}, 0.3});
        send(SetHands{{false, {}}, {}, {}, {}});
        send(SetHands{{}, {}, 2.0, {}});
        send(SetMaterial{ObjectId{1}, material_spec("snow")});
        send(SetMaterial{ObjectId{2}, material_spec("snow")});  // refused
        send(Pause{true});
        send(Advance{1});
        send(Advance{1});
        send(Carry{{ObjectId{1}}, left, true});
        send(Carry{{ObjectId{1}}, left, false});
        send(Mark{"a"});
        send(Mark{"b"});
    }
    const std::vector<Command> applied = taken_from(session);
    std::string names;
    for (const Command& command : applied) names += std::string(row_of(command).name) + " ";
    EXPECT_EQ(names,
              "set_walls set_walls set_hands set_hands set_material pause advance advance carry "
              "carry mark mark ");
    const auto state = session.state();
    EXPECT_EQ(state->document->scene->walls.friction, 0.3);
    EXPECT_EQ(state->document->scene->walls.mode, ContactMode::slip);
    EXPECT_EQ(state->document->scene->walls.min.x, walls.min.x);
    EXPECT_EQ(state->document->hands->zoom, 2);
    EXPECT_FALSE(state->document->hands->present[left]);
    EXPECT_EQ(state->refused, 1);
}

// A request to cut the current frame ends with its command, also in a drag.
TEST_F(Live, FramesAreWholeAgainAfterCommandsThatCutThem)
{
    options.budget = 1e9;
    prepare = [](Slow& s) { s.substep = 1e-5; };
    LiveSession session(scene, options);
    session.wait_for_commands();
    {
        const Blocked blocked(session);
        for (int i = 0; i < 5; ++i) session.send(SetLattice{16 + i}, Origin::window, 9);
        session.send(Open{"scenes/no_such_scene.json", {}, {}}, Origin::window, 9);
        session.send(Reset{}, Origin::window, 9);
    }
    session.wait_for_commands();
    const auto begun = session.state();
    EXPECT_EQ(begun->history, 2);
    const auto state = once(session, [this](const LiveState& s) {
        clock = clock + 1e-4;
        return s.frame.number > 3;
    });
    EXPECT_EQ(state->backlog.frames, 0);
    EXPECT_FALSE(state->frame.stats.cut);
}

SceneObject small_ball(const Document& d)
{
    SceneObject o = *d.objects.at(0);
    o.id = {}, o.name = "small", o.material = material_spec("clay");
    o.source.shape = ShapeKind::sphere, o.source.size = {0.1, 0.1, 0.1};
    o.pose.p = 0.5 * (d.scene->walls.min + d.scene->walls.max);
    o.source.per_cell = 2;
    return o;
}

// In real time clay is prepared on another thread, and the commands behind it wait.
TEST_F(Live, NewObjectsArePreparedBesideTheFrames)
{
    options.make_solver = cpu_solver;
    LiveSession session(scene, options);
    session.wait_for_commands();
    SceneObject o = small_ball(*session.state()->document);
    const ObjectRef first = ObjectId{1};
    session.send(RemoveObjects{{first}});
    session.send(AddObject{o});
    session.send(Rename{ObjectRef("small"), "renamed"});
    session.wait_for_commands();
    ASSERT_EQ(session.state()->document->objects.size(), 1u) << session.state()->refusal;
    EXPECT_EQ(session.state()->document->objects[0]->name, "renamed");
    std::size_t particles = 0;
    session.inspect_solver([&](const Simulator& s) { particles = s.particles().size(); });
    EXPECT_GT(particles, 0u);
    // What is refused is not prepared, and leaves nothing that the next would take.
    o.source.size = {1e3, 1e3, 1e3};
    session.send(AddObject{o});
    session.wait_for_commands();
    EXPECT_NE(session.state()->refusal.find("object: expected the object between the walls"),
              std::string::npos)
        << session.state()->refusal;
    o.source.size.x = std::nan("");
    session.send(AddObject{o});
    session.wait_for_commands();
    EXPECT_EQ(session.state()->refused, 2);
    o.source.size = {0.1, 0.1, 0.1};
    session.send(AddObject{o});  // its place is taken
    session.wait_for_commands();
    EXPECT_NE(session.state()->refusal.find("other clay fills"), std::string::npos)
        << session.state()->refusal;
    EXPECT_EQ(session.state()->document->objects.size(), 1u);
}

TEST_F(Live, ASessionMayEndWhileAnObjectIsPrepared)
{
    options.make_solver = cpu_solver;
    for (int round = 0; round < 20; ++round) {
        LiveSession session(scene, options);
        session.wait_for_commands();
        const SceneObject o = small_ball(*session.state()->document);
        session.send(RemoveObjects{{ObjectRef(ObjectId{1})}});
        session.send(AddObject{o});
        if (round % 2 == 0) session.send(Reset{});
        std::this_thread::sleep_for(std::chrono::microseconds(100 * round));
    }
}

TEST_F(Live, OfMoreThan4096WaitingCommandsTheRestIsRefusedAtOnce)
{
    LiveSession session(scene, options);
    session.wait_for_commands();
    {
        const Blocked blocked(session);
        for (int i = 0; i < 4096; ++i) ASSERT_EQ(session.send(Mark{"x"}), i + 1);
        EXPECT_EQ(session.send(Mark{"too many"}), 0);
    }
    session.wait_for_commands();
    EXPECT_EQ(session.send(Mark{"again"}), 4097);
    EXPECT_EQ(taken_from(session).size(), 4097u);
}

TEST(LiveSessionWithoutAScene, RefusesWhatNeedsOne)
{
    LiveSession session(nullptr, {});
    for (const Command& command :
         {Command(SetLattice{16}), Command(SetGravity{{0, 0, 0}}),
          Command(Rename{ObjectId{1}, "a"}), Command(Carry{{ObjectId{1}}, left, true}),
          Command(SetSurface{30})}) {
        const long serial = session.send(command);
        session.wait_for_commands();
        const auto state = session.state();
        EXPECT_EQ(state->answered, serial);
        EXPECT_EQ(state->refused, serial);
        EXPECT_FALSE(state->document);
    }
    session.send(Mark{"x"}), session.send(Pause{true}), session.send(Play{true});
    session.send(Reset{});
    EXPECT_EQ(taken_from(session).size(), 4u);
}

}  // namespace
}  // namespace knead
