// The history against a reference that keeps whole copies of every step: any order of changes,
// captures that are late, undo, redo, branches, and budgets so small that steps are always evicted.
#include "host/session/history.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <deque>
#include <set>
#include <stdexcept>

#include "tests/sanitized.h"
#include "tests/session/clay_rows.h"

namespace knead {
namespace {

using Rows = std::shared_ptr<const ClayRows>;
using Splats = std::shared_ptr<const CarriedSplats>;

DocumentPtr document_with(double gravity)
{
    Document d;
    SceneSettings scene;
    scene.gravity.y = gravity;
    d.scene = std::make_shared<const SceneSettings>(scene);
    return std::make_shared<const Document>(d);
}
std::shared_ptr<const ObjectNumbers> numbers_with(int number)
{
    ObjectNumbers n;
    n.number[{1}] = {number};
    return std::make_shared<const ObjectNumbers>(n);
}
Splats some_splats(std::size_t count)
{
    CarriedSplats s;
    s.extent.resize(count);
    return std::make_shared<const CarriedSplats>(s);
}

FutureCapture at_once(Capture made)
{
    std::promise<Capture> promise;
    promise.set_value(std::move(made));
    return promise.get_future().share();
}
FutureCapture failed(const char* why)
{
    std::promise<Capture> promise;
    promise.set_exception(std::make_exception_ptr(std::runtime_error(why)));
    return promise.get_future().share();
}

HistoryStep first_step()
{
    HistoryStep step;
    step.label = "Open", step.document = document_with(0), step.objects = numbers_with(0);
    return step;
}
// A step after the current one, captured with these rows.
StepId add_step(History& history, const Rows& rows, const Splats& splats = nullptr)
{
    const StepId id = history.open("Press", document_with(1), numbers_with(1));
    history.capture(at_once(capture_of(*history.resident(), rows)), splats, long(id));
    return id;
}
std::vector<StepId> ids_of(const History& history)
{
    std::vector<StepId> ids;
    for (const StepInfo& info : history.list()) ids.push_back(info.id);
    return ids;
}
using Ids = std::vector<StepId>;

// A history with a beginning, and clay for more steps.
struct Begun {
    explicit Begun(std::size_t budget = std::size_t(1) << 20) : history(budget)
    {
        history.begin(first_step(), next());
    }
    Rows next()
    {
        last = changed(random, last, 5);
        return std::make_shared<const ClayRows>(last);
    }
    void go_to(StepId id) { history.go_to(id, history.rows_of(id)); }

    std::mt19937 random{1};
    ClayRows last = random_rows(random, 30, 2);
    History history;
};

TEST(History, WithoutStepsThereIsNothingToEvict)
{
    History h;
    h.evict();
    EXPECT_EQ(h.count(), 0u);
    EXPECT_EQ(h.bytes(), 0u);
}

TEST(History, UndoAndRedoFollowTheLineAndANewStepAfterUndoIsABranch)
{
    Begun b;
    History& h = b.history;
    EXPECT_FALSE(h.undo());
    EXPECT_FALSE(h.redo());
    for (int i = 0; i < 3; ++i) add_step(h, b.next());
    EXPECT_EQ(h.current().id, 3u);
    b.go_to(*h.undo()), b.go_to(*h.undo());
    EXPECT_EQ(h.current().id, 1u);
    EXPECT_EQ(h.redo(), 2u);
    add_step(h, b.next());
    EXPECT_EQ(h.undo(), 1u);
    EXPECT_FALSE(h.redo());
    std::set<StepId> line;
    for (const StepInfo& s : h.list())
        if (s.on_line) line.insert(s.id);
    EXPECT_EQ(line, (std::set<StepId>{0, 1, 4}));
    // The other branch is the line again once it has been gone to.
    b.go_to(3), b.go_to(1);
    EXPECT_EQ(h.redo(), 2u);
    EXPECT_EQ(h.count(), 5u);
}

TEST(History, AStepThatChangedNoClayHasItsParentsRowsAndTakesNoBytes)
{
    Begun b;
    History& h = b.history;
    add_step(h, b.next(), some_splats(10));
    h.evict();
    const std::size_t before = h.bytes();
    const StepId id = h.open("Rename", document_with(2), numbers_with(1));
    EXPECT_THROW(h.open("Rename", document_with(2), numbers_with(1)), std::logic_error);
    EXPECT_THROW(h.rows_of(id), std::invalid_argument);
    h.update(document_with(3), numbers_with(2));
    const Rows rows = h.resident();
    h.capture_unchanged(7);
    EXPECT_THROW(h.update(document_with(3), numbers_with(2)), std::logic_error);
    EXPECT_THROW(h.capture_unchanged(8), std::logic_error);
    h.evict();
    EXPECT_EQ(h.bytes(), before);
    EXPECT_EQ(h.rows_of(id), rows);
    EXPECT_EQ(h.resident(), rows);
    EXPECT_EQ(h.current().frame, 7);
    EXPECT_EQ(h.current().splats, h.find(1)->splats);
    EXPECT_TRUE(equal(*h.current().document, *document_with(3)));
}

TEST(History, ALateCaptureIsNeitherWaitedForNorEvicted)
{
    Begun b(0);
    History& h = b.history;
    const Rows first = h.resident(), second = b.next();
    std::promise<Capture> late;
    h.open("Press", document_with(1), numbers_with(1));
    h.capture(late.get_future().share(), nullptr, 1);
    h.evict();
    EXPECT_FALSE(h.resident_ready());
    EXPECT_EQ(h.bytes(), 0u);
    // Back without waiting, and another step.
    b.go_to(0);
    EXPECT_TRUE(h.resident_ready());
    add_step(h, b.next());
    h.evict();
    EXPECT_TRUE(h.find(1));
    late.set_value(capture_of(*first, second));
    EXPECT_TRUE(same_rows(*h.rows_of(1), *second));
    h.evict();
    EXPECT_FALSE(h.find(1));
    EXPECT_THROW(h.rows_of(1), std::invalid_argument);
}

TEST(History, StepsBehindACaptureThatFailedAreLostAndNoOthers)
{
    Begun b;
    History& h = b.history;
    const Rows one = b.next();
    add_step(h, one);
    const StepId lost = h.open("Press", document_with(1), numbers_with(1));
    h.capture(failed("out of memory"), nullptr, 2);
    for (int i = 0; i < 2; ++i) {
        EXPECT_TRUE(h.resident_ready());
        EXPECT_THROW(h.resident(), std::runtime_error);
        EXPECT_THROW(h.rows_of(lost), std::runtime_error);
        EXPECT_TRUE(same_rows(*h.rows_of(1), *one));
        EXPECT_EQ(h.rows_of(0)->count, 30u);
        h.evict();
    }
    EXPECT_EQ(h.undo(), 1u);
    b.go_to(1);
    const Rows other = b.next();
    add_step(h, other);
    b.go_to(0), b.go_to(3);
    EXPECT_TRUE(same_rows(*h.resident(), *other));
    EXPECT_THROW(h.rows_of(lost), std::runtime_error);
}

TEST(History, OnlyRowsOfTheCurrentStepAndOfItsParentStayInMemory)
{
    Begun b;
    std::vector<std::weak_ptr<const ClayRows>> all;
    for (int i = 0; i < 5; ++i) {
        const Rows rows = b.next();
        all.push_back(rows);
        add_step(b.history, rows);
        b.history.evict();
    }
    for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i].expired(), i < 3) << i;
}

TEST(History, UndoAndRedoOfTheNewestStepDecodeNothing)
{
    for (const bool late : {false, true}) {
        Begun b;
        History& h = b.history;
        const Rows one = b.next(), two = b.next();
        add_step(h, one);
        h.evict();
        std::promise<Capture> made;
        h.open("Press", document_with(1), numbers_with(1));
        h.capture(made.get_future().share(), nullptr, 2);
        if (!late) made.set_value(capture_of(*one, two)), h.evict();
        h.open("Rename", document_with(2), numbers_with(1));
        h.capture_unchanged(3);
        for (int i = 0; i < 2; ++i) {
            EXPECT_EQ(h.rows_of(1), one);
            b.go_to(1);
            if (late && i == 0) made.set_value(capture_of(*one, two));
            h.evict();
            EXPECT_EQ(h.rows_of(2), two);
            EXPECT_EQ(h.rows_of(3), two);
            b.go_to(3);
            h.evict();
        }
        // Of an older one, from the nearer rows.
        b.go_to(1);
        EXPECT_TRUE(same_rows(*h.rows_of(0), *h.rows_of(0)));
        EXPECT_EQ(h.rows_of(2), two);
    }
}

// Lossless and quantised steps in one history, to the bit.
TEST(History, StepsOfBothCodecsFollowEachOther)
{
    const auto steps = std::make_shared<const Quantisation>(coarse_steps());
    Begun b(std::size_t(1) << 24);
    History& h = b.history;
    std::vector<Rows> all{h.resident()};
    for (int i = 1; i < 30; ++i) {
        const bool rounds = i / 3 % 2;
        const Rows next = b.next(),
                   rows =
                       rounds ? std::make_shared<const ClayRows>(quantised(*next, *steps)) : next;
        const StepId id = h.open("Press", document_with(1), numbers_with(1));
        h.capture(at_once(capture_of(*h.resident(), rows, rounds ? steps : nullptr)), nullptr,
                  long(id));
        all.push_back(rows);
        h.evict();
    }
    for (int i = 0; i < 200; ++i) {
        const StepId to = b.random() % all.size();
        EXPECT_TRUE(same_rows(*h.rows_of(to), *all[to]));
        b.go_to(to);
    }
}

TEST(History, BranchesGoFirstThenTheEndOfRedoThenTheOldestOfUndo)
{
    Begun b(0);
    History& h = b.history;
    // Fewer than fewest_steps are kept whatever the budget.
    for (int i = 0; i < 6; ++i) add_step(h, b.next());
    h.evict();
    EXPECT_EQ(h.count(), 7u);
    b.go_to(4);
    add_step(h, b.next());  // 7 is beside 5 and 6
    h.evict();
    EXPECT_EQ(ids_of(h), (Ids{0, 1, 2, 3, 4, 7}));
    for (int i = 0; i < 6; ++i) add_step(h, b.next());
    h.evict();
    EXPECT_EQ(ids_of(h), (Ids{3, 4, 7, 8, 9, 10, 11, 12, 13}));
    b.go_to(3);
    EXPECT_FALSE(h.undo());
    h.evict();
    EXPECT_EQ(h.count(), 9u);
    b.go_to(13);
    EXPECT_EQ(h.undo(), 12u);
}

TEST(History, SplatsCountOnceAndGoWithTheLastStepThatHasThem)
{
    Begun b(0);
    History& h = b.history;
    const Splats one = some_splats(1000), other = some_splats(500);
    const auto of_edges = [&] {
        std::size_t sum = 0;
        for (const StepInfo& info : h.list()) sum += info.bytes;
        return sum;
    };
    for (int i = 0; i < 3; ++i) add_step(h, b.next(), one);
    h.evict();
    EXPECT_EQ(h.bytes(), of_edges() + bytes_of(*one));
    for (int i = 0; i < 8; ++i) add_step(h, b.next(), other);
    h.evict();
    EXPECT_EQ(h.bytes(), of_edges() + bytes_of(*one) + bytes_of(*other));
    add_step(h, b.next(), other);
    h.evict();
    EXPECT_EQ(h.bytes(), of_edges() + bytes_of(*other));
    EXPECT_EQ(one.use_count(), 1);
    h.begin(first_step(), b.next());
    EXPECT_EQ(h.bytes(), 0u);
    EXPECT_EQ(h.count(), 1u);
}

TEST(History, StepsOfAFileAreAddedWithTheirNumbers)
{
    Begun b;
    History& h = b.history;
    const Rows first = h.resident(), second = b.next(), third = b.next();
    HistoryStep step = first_step();
    step.id = 4;
    h.insert(step, capture_of(*first, second));
    step.id = 9, step.parent = 4;
    h.insert(step, {});
    step.id = 11;
    h.insert(step, capture_of(*second, third));
    EXPECT_EQ(h.current().id, 0u);
    EXPECT_THROW(h.insert(step, {}), std::invalid_argument);
    step.id = 12, step.parent = 5;
    EXPECT_THROW(h.insert(step, {}), std::invalid_argument);
    b.go_to(11);
    EXPECT_TRUE(same_rows(*h.resident(), *third));
    EXPECT_TRUE(same_rows(*h.rows_of(9), *second));
    EXPECT_EQ(add_step(h, b.next()), 12u);
    EXPECT_EQ(h.undo(), 11u);
}

// All of a step, and of what undo and redo should do.
struct Reference {
    StepId parent = 0;
    std::string label;
    DocumentPtr document;
    int number = 0;
    long frame = 0;
    Splats splats;
    Rows rows;  // null: open
    std::optional<StepId> redo{};
    bool unchanged = false;  // as its parent
};

class Model {
  public:
    Model(std::uint32_t seed, std::size_t most_bytes)
        : random(seed), budget(most_bytes), history(most_bytes)
    {
        Reference& r = all[0];
        r.label = "Open", r.document = document_with(0);
        r.splats = random() % 2 ? some_splats(20) : nullptr;
        r.rows = std::make_shared<const ClayRows>(random_rows(random, 20, random() % 2 * 3));
        HistoryStep first = first_step();
        first.splats = r.splats;
        history.begin(first, r.rows);
    }

    void operate()
    {
        const auto what = int(random() % 100);
        if (what < 10)
            run_late(1);
        else if (what < 20)
            evict();
        else if (!all.at(at).rows)
            what < 35 ? update() : capture();
        else if (what < 60)
            open();
        else
            travel(what);
        compare();
    }
    void finish()
    {
        run_late(late.size());
        if (!all.at(at).rows) capture();
        run_late(late.size());
        evict();
        for (const auto& [id, step] : all) {
            EXPECT_TRUE(same_rows(*history.rows_of(id), *step.rows));
            go_to(id);
            compare();
        }
    }
    std::size_t evicted = 0, travelled = 0, ordered = 0;

  private:
    void open()
    {
        Reference r;
        r.parent = at, r.label = std::to_string(random());
        r.document = document_with(double(random())), r.number = int(random() % 1000);
        r.splats = all.at(at).splats;
        at = history.open(r.label, r.document, numbers_with(r.number));
        EXPECT_GT(at, last);
        last = at;
        all.at(r.parent).redo = at;
        all[at] = r;
    }
    void update()
    {
        Reference& r = all.at(at);
        r.document = document_with(double(random())), r.number = int(random() % 1000);
        history.update(r.document, numbers_with(r.number));
    }
    Rows other_rows(const ClayRows& before)
    {
        if (random() % 5 > 0)
            return std::make_shared<const ClayRows>(changed(random, before, random() % 20));
        return std::make_shared<const ClayRows>(
            random_rows(random, random() % 25, random() % 2 * (random() % 4)));
    }
    void capture()
    {
        Reference& r = all.at(at);
        const Rows before = all.at(r.parent).rows;
        r.frame = long(random());
        if (random() % 6 == 0) {
            r.rows = before, r.unchanged = true;
            history.capture_unchanged(r.frame);
            return;
        }
        r.rows = other_rows(*before);
        if (r.splats && random() % 4 == 0) r.splats = some_splats(random() % 40);
        std::shared_ptr<const Quantisation> steps;
        if (random() % 2) {
            steps = std::make_shared<const Quantisation>(coarse_steps());
            r.rows = std::make_shared<const ClayRows>(quantised(*r.rows, *steps));
        }
        const auto make = [rows = r.rows, steps, now = history.resident_later()] {
            return capture_of(*now.get(), rows, steps);
        };
        FutureCapture made;
        switch (random() % 3) {
            case 0:  // when it is waited for, and never else
                made = std::async(std::launch::deferred, make).share();
                break;
            default:
                late.emplace_back(make);
                made = late.back().get_future().share();
        }
        history.capture(made, r.splats, r.frame);
        if (random() % 2) run_late(late.size());
    }
    // In their order, since each needs the rows of the one before.
    void run_late(std::size_t count)
    {
        for (; count > 0 && !late.empty(); --count) {
            late.front()();
            late.pop_front();
        }
    }
    void travel(int what)
    {
        StepId to = at;
        if (what < 80) {
            to = history.undo().value_or(at);
        } else if (what < 90) {
            to = history.redo().value_or(at);
        } else {
            auto any = all.begin();
            std::advance(any, random() % all.size());
            to = any->first;
        }
        run_late(late.size());  // they may be waited for
        go_to(to);
    }
    void go_to(StepId to)
    {
        const Rows rows = history.rows_of(to);
        EXPECT_TRUE(same_rows(*rows, *all.at(to).rows));
        history.go_to(to, rows);
        ++travelled;
        at = to;
        for (StepId id = to; all.contains(all.at(id).parent) && id != 0; id = all.at(id).parent)
            all.at(all.at(id).parent).redo = id;
    }

    std::size_t bytes_of_list() const
    {
        std::size_t sum = 0;
        for (const StepInfo& info : history.list()) sum += info.bytes;
        std::set<Splats> splats;
        for (const auto& [id, step] : all)
            if (step.splats && history.find(id)->captured) splats.insert(step.splats);
        for (const Splats& one : splats) sum += bytes_of(*one);
        return sum;
    }
    void evict()
    {
        if (random() % 3 == 0) {  // now no capture is late
            run_late(late.size());
            for (const auto& [id, step] : all)
                if (step.rows) history.rows_of(id);
        }
        const std::vector<StepInfo> before = history.list();
        Ids line;
        std::size_t here = 0;
        for (const StepInfo& info : before) {
            if (info.current) here = line.size();
            if (info.on_line) line.push_back(info.id);
        }
        history.evict();
        for (std::size_t i = 0; i < line.size(); ++i) {
            const std::size_t apart = i > here ? i - here : here - i;
            if (apart <= History::fewest_steps / 2) {
                EXPECT_TRUE(history.find(line[i]));
            }
        }
        for (const StepInfo& info : before)
            if (!history.find(info.id)) all.erase(info.id), ++evicted;
        for (auto& [id, step] : all) {
            if (!step.redo || all.contains(*step.redo)) continue;
            step.redo.reset();
            for (const auto& [other, child] : all)
                if (child.parent == id && other != id) step.redo = other;
        }
        EXPECT_EQ(history.bytes(), bytes_of_list());
        EXPECT_GE(all.size(), std::min(line.size(), History::fewest_steps + 1));
        check_order(line);
    }
    // What was removed before what, if no capture is late.
    void check_order(const Ids& line)
    {
        std::size_t off_line = 0, before = 0, after = 0;
        for (const StepInfo& info : history.list()) {
            const Reference& step = all.at(info.id);
            // Such captures are ready when they are waited for, and not before.
            if (step.rows && all.contains(step.parent) && info.id != 0 && !step.unchanged &&
                info.bytes == 0)
                return;
            if (info.on_line) (info.id < at ? before : after) += info.id != at;
            off_line += !info.on_line;
        }
        ++ordered;
        if (!history.find(line.front()) || !history.find(line.back())) {
            EXPECT_EQ(off_line, 0u);
        }
        if (!history.find(line.front())) {
            EXPECT_LE(after, History::fewest_steps - std::min<std::size_t>(before, 4));
        }
        if (history.bytes() > budget) {
            EXPECT_EQ(off_line, 0u);
            EXPECT_LE(before + after, History::fewest_steps);
        }
    }

    void compare()
    {
        ASSERT_EQ(history.count(), all.size());
        const HistoryStep& current = history.current();
        const Reference& r = all.at(at);
        ASSERT_EQ(current.id, at);
        EXPECT_EQ(current.captured, bool(r.rows));
        const StepId parent = r.parent;
        EXPECT_EQ(history.undo(),
                  at != 0 && all.contains(parent) ? std::optional(parent) : std::nullopt);
        EXPECT_EQ(history.redo(), r.redo);
        // Any step.
        auto any = all.begin();
        std::advance(any, random() % all.size());
        const HistoryStep* step = history.find(any->first);
        ASSERT_TRUE(step);
        const Reference& one = any->second;
        EXPECT_EQ(step->label, one.label);
        EXPECT_TRUE(equal(*step->document, *one.document));
        EXPECT_EQ(step->objects->number.at({1}), std::vector<int>{one.number});
        if (!one.rows) return;
        EXPECT_EQ(step->splats, one.splats);
        EXPECT_EQ(step->frame, one.frame);
        if (random() % 8 > 0) return;
        run_late(late.size());
        EXPECT_TRUE(same_rows(*history.rows_of(any->first), *one.rows));
        const Rows resident = r.rows ? r.rows : all.at(r.parent).rows;
        EXPECT_TRUE(same_rows(*history.resident(), *resident));
    }

    std::mt19937 random;
    const std::size_t budget;
    History history;
    std::map<StepId, Reference> all;
    std::deque<std::packaged_task<Capture()>> late;
    StepId at = 0, last = 0;
};

TEST(History, AnyOrderOfOperationsLeadsToTheStepsOfTheReference)
{
    const bool is_long = std::getenv("KNEAD_LONG");
    const int operations = is_long ? 1000000 : sanitized ? 3000 : 10000, of_one = 1000;
    const std::uint32_t seed = is_long ? std::random_device{}() : 59;
    SCOPED_TRACE(seed);
    const std::size_t budgets[] = {0, 20000, 60000};
    std::size_t evicted = 0, travelled = 0, ordered = 0;
    for (int i = 0; i < operations / of_one && !HasFailure(); ++i) {
        SCOPED_TRACE(i);
        Model model(seed + std::uint32_t(i), budgets[i % 3]);
        for (int n = 0; n < of_one && !HasFailure(); ++n) model.operate();
        model.finish();
        evicted += model.evicted, travelled += model.travelled;
        ordered += model.ordered;
    }
    EXPECT_GT(evicted, std::size_t(operations / 50));
    EXPECT_GT(travelled, std::size_t(operations / 10));
    EXPECT_GT(ordered, std::size_t(operations / 50));
}

}  // namespace
}  // namespace knead
