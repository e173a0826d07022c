#include "host/session/history.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <set>
#include <stdexcept>
#include <utility>

namespace knead {
namespace {

bool ready(const FutureCapture& made)
{
    return made.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

template <class Numbers>
std::size_t bytes_in(const Numbers& numbers)
{
    return numbers.size() * sizeof numbers[0];
}

std::size_t bytes_of(const InitialState& state)
{
    return bytes_in(state.particles) + bytes_in(state.gaussians);
}

}  // namespace

Capture capture_of(const ClayRows& parent, std::shared_ptr<const ClayRows> rows,
                   std::shared_ptr<const Quantisation> steps)
{
    auto edge = std::make_shared<ClayEdge>();
    if (same_members(parent, *rows))
        edge->from_parent = difference(parent, *rows, steps.get());
    else
        edge->parent_whole = encoded(parent, steps.get()),
        edge->whole = encoded(*rows, steps.get());
    const std::uint64_t h = hash_after(edge->whole.empty() ? edge->from_parent : edge->whole);
    return {std::move(rows), h, std::move(edge), std::move(steps)};
}

std::size_t bytes_of(const CarriedSplats& splats)
{
    const SplatCloud& c = splats.cloud;
    return bytes_in(c.centre) + bytes_in(c.rotation) + bytes_in(c.scale) + bytes_in(c.opacity) +
           bytes_in(c.sh) + bytes_in(splats.extent);
}

bool LaterRows::ready() const { return !made.valid() || knead::ready(made); }

std::shared_ptr<const ClayRows> LaterRows::get() const
{
    if (failure) std::rethrow_exception(failure);
    return made.valid() ? made.get().rows : rows;
}

void History::keep_shared(const HistoryStep& step)
{
    if (step.splats && ++shared[step.splats.get()] == 1) sum += bytes_of(*step.splats);
    if (step.beginning && ++shared[step.beginning.get()] == 1) sum += bytes_of(*step.beginning);
}

void History::drop_shared(const HistoryStep& step)
{
    const auto drop = [&](const auto& part) {
        if (!part || --shared.at(part.get()) > 0) return;
        shared.erase(part.get());
        sum -= bytes_of(*part);
    };
    drop(step.splats), drop(step.beginning);
}

void History::begin(HistoryStep first, std::shared_ptr<const ClayRows> of_first)
{
    ++changes;
    steps.clear(), edges.clear(), newest.clear(), waiting.clear(), shared.clear();
    sum = 0;
    at = last = rows_at = first.id;
    rows = std::move(of_first), beside = nullptr;
    first.captured = true;
    keep_shared(first);
    steps.emplace(at, std::move(first));
}

void History::insert(HistoryStep step, Capture made)
{
    ++changes;
    captured(step.parent);
    if (step.id <= last)
        throw std::invalid_argument(
            fmt::format("step {} cannot be added after step {}", step.id, last));
    last = step.id;
    step.captured = true;
    keep_shared(step);
    sum += made.bytes();
    edges[step.id].clay = std::move(made.edge);
    newest.try_emplace(step.parent, step.id);
    steps.emplace(step.id, std::move(step));
}

StepId History::open(std::string label, DocumentPtr document,
                     std::shared_ptr<const ObjectNumbers> objects)
{
    ++changes;
    if (!current().captured) throw std::logic_error("a step is open already");
    HistoryStep step;
    step.id = ++last, step.parent = at;
    step.label = std::move(label);
    step.document = std::move(document), step.objects = std::move(objects);
    newest[at] = step.id;
    at = step.id;
    steps.emplace(at, std::move(step));
    return at;
}

HistoryStep& History::opened(const char* action)
{
    ++changes;
    HistoryStep& step = steps.at(at);
    if (step.captured) throw std::logic_error(fmt::format("no step is open to be {}", action));
    return step;
}

void History::update(DocumentPtr document, std::shared_ptr<const ObjectNumbers> objects)
{
    HistoryStep& step = opened("changed");
    step.document = std::move(document), step.objects = std::move(objects);
}

void History::capture_unchanged(long frame)
{
    HistoryStep& step = opened("captured");
    step.splats = steps.at(step.parent).splats;
    keep_shared(step);
    step.frame = frame, step.captured = true;
    edges[at] = {};
}

void History::capture(FutureCapture made, std::shared_ptr<const CarriedSplats> splats, long frame)
{
    HistoryStep& step = opened("captured");
    if (!made.valid()) throw std::invalid_argument("a capture is missing");
    step.splats = std::move(splats);
    keep_shared(step);
    step.frame = frame, step.captured = true;
    edges[at].made = std::move(made);
    waiting.push_back(at);
}

const HistoryStep* History::find(StepId id) const
{
    const auto found = steps.find(id);
    return found == steps.end() ? nullptr : &found->second;
}

const HistoryStep& History::captured(StepId id) const
{
    const HistoryStep* step = find(id);
    if (!step) throw std::invalid_argument(fmt::format("step {} is not in the history", id));
    if (!step->captured) throw std::invalid_argument(fmt::format("step {} is open", id));
    return *step;
}

std::optional<StepId> History::undo() const
{
    const StepId parent = current().parent;
    if (parent == at || !find(parent)) return {};
    return parent;
}

std::optional<StepId> History::redo() const
{
    const auto next = newest.find(at);
    if (next == newest.end()) return {};
    return next->second;
}

// From a step to the oldest one, both included.
std::vector<StepId> History::way_to_root(StepId id) const
{
    std::vector<StepId> way;
    for (const HistoryStep* step = find(id); step; step = find(step->parent)) {
        way.push_back(step->id);
        if (step->parent == step->id) break;
    }
    return way;
}

// From the oldest step over the current one to the newest.
std::vector<StepId> History::line() const
{
    std::vector<StepId> all = way_to_root(at);
    std::reverse(all.begin(), all.end());
    for (auto next = newest.find(at); next != newest.end(); next = newest.find(next->second))
        all.push_back(next->second);
    return all;
}

// The way back over steps without a change of clay ends at rows, or at the capture of some.
LaterRows History::resident_later() const
{
    StepId step = current().captured ? at : current().parent;
    for (; step != rows_at; step = steps.at(step).parent) {
        const Edge& edge = edges.at(step);
        if (edge.made.valid() || edge.failure) return {nullptr, edge.made, edge.failure};
    }
    return {rows, {}, nullptr};
}

// Null: unchanged. Waits for the capture, and throws what it threw.
const ClayEdge* History::clay_of(const Edge& edge)
{
    if (edge.failure) std::rethrow_exception(edge.failure);
    return edge.made.valid() ? edge.made.get().edge.get() : edge.clay.get();
}

// Up to the last common step, then down.
std::vector<History::Move> History::moves(StepId from, StepId to) const
{
    std::vector<StepId> up = way_to_root(from), down = way_to_root(to);
    while (!up.empty() && !down.empty() && up.back() == down.back()) up.pop_back(), down.pop_back();
    std::reverse(down.begin(), down.end());
    std::vector<Move> all;
    for (const StepId step : up) all.push_back({&edges.at(step), false});
    for (const StepId step : down) all.push_back({&edges.at(step), true});
    return all;
}

// From the rows in memory that are fewer changes away.
std::shared_ptr<const ClayRows> History::rows_of(StepId id) const
{
    captured(id);
    const std::vector<Move> way = moves(rows_at, id);
    if (!beside) return moved(rows, way);
    const auto changes_of = [](const std::vector<Move>& all) {
        return std::ranges::count_if(all, [](const Move& move) {
            return move.edge->made.valid() || move.edge->clay || move.edge->failure;
        });
    };
    const std::vector<Move> other = moves(beside_at, id);
    return changes_of(other) < changes_of(way) ? moved(beside, other) : moved(rows, way);
}

std::shared_ptr<const ClayRows> History::moved(std::shared_ptr<const ClayRows> found,
                                               const std::vector<Move>& moves)
{
    // What comes before a move that gives whole rows is not needed.
    std::size_t first = moves.size();
    for (; first > 0; --first) {
        const auto [edge, forward] = moves[first - 1];
        if (forward && edge->made.valid()) {
            found = edge->made.get().rows;
            break;
        }
        const ClayEdge* const clay = clay_of(*edge);
        if (!clay || clay->whole.empty()) continue;
        found =
            std::make_shared<const ClayRows>(decoded(forward ? clay->whole : clay->parent_whole));
        break;
    }
    std::shared_ptr<ClayRows> changed;
    for (std::size_t i = first; i < moves.size(); ++i) {
        const ClayEdge* const clay = clay_of(*moves[i].edge);
        if (!clay) continue;
        if (!changed) changed = std::make_shared<ClayRows>(*found);
        apply_difference(*changed, clay->from_parent);
    }
    return changed ? std::move(changed) : found;
}

bool History::same_clay(StepId one, StepId other) const
{
    const std::vector<StepId> a = way_to_root(one), b = way_to_root(other);
    const auto from_root = std::ranges::mismatch(a.rbegin(), a.rend(), b.rbegin(), b.rend());
    const auto unchanged = [&](auto from, auto to) {
        return std::all_of(from, to, [&](StepId step) {
            const auto edge = edges.find(step);
            return edge != edges.end() && !edge->second.made.valid() && !edge->second.clay &&
                   !edge->second.failure;
        });
    };
    return unchanged(from_root.in1, a.rend()) && unchanged(from_root.in2, b.rend());
}

void History::go_to(StepId id, std::shared_ptr<const ClayRows> of_step)
{
    ++changes;
    if (!current().captured) throw std::logic_error("the current step is open");
    captured(id);
    const std::vector<StepId> way = way_to_root(id);
    for (std::size_t i = 1; i < way.size(); ++i) newest[way[i]] = way[i - 1];
    if (of_step != rows) beside_at = rows_at, beside = std::exchange(rows, std::move(of_step));
    at = rows_at = id;
}

// Takes the edges of all captures that are ready, and the rows of the last one up to the current
// step. Steps without a change of clay have the rows of the step before.
void History::take_captures()
{
    std::vector<StepId> way;  // from the current step back to the one whose rows are known
    for (StepId step = current().captured ? at : current().parent; step != rows_at;
         step = steps.at(step).parent)
        way.push_back(step);
    bool known = true;  // rows of the step before
    for (; !way.empty(); way.pop_back()) {
        Edge& edge = edges.at(way.back());
        if (edge.made.valid() || edge.failure) {
            known = take(edge);
            const std::shared_ptr<const ClayRows> next = known ? edge.made.get().rows : rows;
            if (next != rows) beside_at = rows_at, beside = std::exchange(rows, next);
        }
        if (known) rows_at = way.back();
    }
    std::erase_if(waiting, [&](StepId id) {
        Edge& edge = edges.at(id);
        if (take(edge)) {
            if (redo() == id) beside_at = id, beside = edge.made.get().rows;
            sum += edge.clay->bytes(), edge.made = {}, ++changes;
        }
        return !edge.made.valid();
    });
}

// Whether the capture is ready and has succeeded. Keeps what it threw, or its edge.
bool History::take(Edge& edge)
{
    if (!edge.made.valid() || !ready(edge.made)) return false;
    try {
        edge.clay = edge.made.get().edge;
        return true;
    } catch (...) {
        edge.failure = std::current_exception();
        edge.made = {};
        return false;
    }
}

std::optional<StepId> History::next_to_evict() const
{
    const std::vector<StepId> on_line = line();
    const std::size_t here = std::size_t(std::find(on_line.begin(), on_line.end(), at) -
                                         on_line.begin()),
                      after = on_line.size() - 1 - here;
    std::set<StepId> parents, line_steps(on_line.begin(), on_line.end());
    for (const auto& [id, step] : steps) parents.insert(step.parent);
    const auto is_free = [&](StepId id) {  // nothing is behind it, and its capture is over
        return !parents.contains(id) && !edges.at(id).made.valid();
    };
    // By the first step of a branch, which is not on the line, the last free one behind it.
    std::map<StepId, StepId> branch_of, ends;
    for (const auto& [id, step] : steps) {
        if (line_steps.contains(id)) continue;
        const auto before = branch_of.find(step.parent);
        const StepId branch = before == branch_of.end() ? id : before->second;
        branch_of[id] = branch;
        if (is_free(id)) ends[branch] = id;
    }
    if (!ends.empty()) return ends.begin()->second;

    const std::size_t half = fewest_steps / 2;
    const std::size_t kept_before = fewest_steps - std::min(after, half),
                      kept_after = fewest_steps - std::min(here, half);
    if (after > kept_after && is_free(on_line.back())) return on_line.back();
    if (here <= kept_before) return {};
    // The oldest: the step behind it becomes the oldest, if it is the only one.
    const bool alone = std::count_if(steps.begin(), steps.end(), [&](const auto& one) {
                           return one.second.parent == on_line[0] && one.first != on_line[0];
                       }) == 1;
    const Edge& next = edges.at(on_line[1]);
    if (alone && !next.made.valid() && !next.failure) return on_line[0];
    return {};
}

void History::remove(StepId id)
{
    ++changes;
    const auto cut = [&](StepId step) {  // from its parent
        const auto found = edges.find(step);
        if (found == edges.end()) return;
        if (found->second.clay) sum -= found->second.clay->bytes();
        edges.erase(found);
    };
    const StepId parent = steps.at(id).parent;
    cut(id);
    if (const auto next = newest.find(id); next != newest.end()) {  // it was the oldest
        cut(next->second);
        newest.erase(next);
    }
    if (beside_at == id) beside = nullptr;
    drop_shared(steps.at(id));
    steps.erase(id);
    const auto of_parent = newest.find(parent);
    if (of_parent == newest.end() || of_parent->second != id) return;
    newest.erase(of_parent);
    for (const auto& [other, step] : steps)
        if (step.parent == parent && other != parent) newest[parent] = other;
}

void History::evict()
{
    if (steps.empty()) return;
    take_captures();
    while (sum > budget || steps.size() > most_steps) {
        const std::optional<StepId> next = next_to_evict();
        if (!next) return;
        remove(*next);
    }
}

std::vector<StepInfo> History::list() const
{
    const std::vector<StepId> on_line = line();
    const std::set<StepId> line_steps(on_line.begin(), on_line.end());
    std::vector<StepInfo> all;
    for (const auto& [id, step] : steps) {
        StepInfo info{id, step.parent, step.label, 0, id == at, line_steps.contains(id)};
        if (const auto edge = edges.find(id); edge != edges.end())
            info.bytes = edge->second.clay ? edge->second.clay->bytes() : 0;
        all.push_back(std::move(info));
    }
    return all;
}

}  // namespace knead
