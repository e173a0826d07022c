#include "host/vr/headset_run.h"

#include <exception>
#include <optional>
#include <stdexcept>
#include <utility>

#include "host/base/machine.h"
#include "host/base/quiet_stderr.h"
#include "xr/advice.h"

namespace knead {
namespace {

constexpr double look_every = 0.02;  // [s]
// Time for an interrupted session to end in order, if the runtime responds [s].
constexpr double orderly_end = 0.4;
// Duration of a call after which a message is printed [s].
constexpr double long_call = 3;
// Time limits for closing a session after its results, and for a single call in it [s].
struct Patience {
    double all, call;
};
constexpr Patience at_its_end{10, 5}, interrupted_end{2, 0.5};

}  // namespace

// Shared by the session's thread and the thread that waits for it. The members below `gate` may be
// accessed only while holding the gate.
struct HeadsetRun::Shared {
    CallGate gate;
    std::unique_ptr<HeadsetSession> session;
    bool opened = false;
    std::optional<HeadsetEnd> end;
    std::exception_ptr failure;  // of open()

    void run_session();
    void take(const std::string& reason)
    {
        if (!end) end = session->results(reason);
    }
};

// Keeps the results of an opened session, however it ends.
void HeadsetRun::Shared::run_session()
{
    gate.begin();
    try {
        session->open();
        opened = true;
        while (session->step()) {
        }
        take("");
        session->close();
    } catch (const std::exception& e) {
        if (opened)
            take(e.what());
        else
            failure = std::current_exception();
    }
    session.reset();
    gate.end();
}

HeadsetRun::HeadsetRun(std::shared_ptr<const LiveScene> scene, const HeadsetLoopOptions& by)
    : shared(std::make_shared<Shared>()), options(by)
{
    shared->session = HeadsetSession::make(std::move(scene), options, shared->gate);
    thread = std::make_unique<AbandonableThread>([all = shared] { all->run_session(); });
}

HeadsetRun::~HeadsetRun()
{
    const Patience longest = options.should_stop() ? interrupted_end : at_its_end;
    const double start = wall_seconds();
    while (!thread->finished_within(look_every))
        if (shared->gate.blocked() > longest.call || wall_seconds() - start > longest.all) return;
}

HeadsetEnd HeadsetRun::wait()
{
    std::optional<double> interrupted_at;
    bool reported = false;
    while (!thread->finished_within(look_every)) {
        const double blocked = shared->gate.blocked();
        if (!interrupted_at && options.should_stop()) interrupted_at = wall_seconds();
        if (blocked > long_call && !std::exchange(reported, true))
            options.notify(xr::no_answer(long_call) +
                           "; Ctrl-C ends the session and writes its results");
        reported = reported && blocked > 0;
        const bool late = interrupted_at && wall_seconds() - *interrupted_at > orderly_end;
        const bool lost = blocked > options.headset.patience;
        if (!shared->gate.enter(0)) continue;
        // A runtime may block the frames of a session that is not visible: not counted as lost.
        if (!shared->end && (late || (lost && shared->session->needs_runtime())))
            shared->take(late ? "" : xr::no_answer(options.headset.patience));
        const bool done = shared->end.has_value();
        shared->gate.leave();
        if (done) break;
    }
    QuietStderr::lift();  // standard error belongs to the caller again
    if (shared->failure) std::rethrow_exception(shared->failure);
    return std::move(*shared->end);
}

}  // namespace knead
