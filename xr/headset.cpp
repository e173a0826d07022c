#include "xr/headset.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <utility>

#include "host/base/quiet_stderr.h"
#include "xr/advice.h"
#include "xr/session.h"

namespace knead {
namespace xr {
namespace {

double wall()  // [s]
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

class OpenXrHeadset : public Headset {
  public:
    explicit OpenXrHeadset(const HeadsetOptions& by) : options(by) { start(); }
    ~OpenXrHeadset() override { OpenXrHeadset::close(); }

    HeadsetEvents poll() override;
    FrameTiming begin() override;
    HeadsetViews locate() override;
    void end(const FrameSubmission& drawn) override;
    void close() override;
    void leave() override;
    void set_floor(Floor floor) override
    {
        moves_floor = moves_floor || floor != options.floor;
        options.floor = floor;
    }
    double time_left() override;
    const HeadsetInfo& facts() const override { return about; }
    void make_current() override
    {
        if (platform) platform->make_current();
    }
    GlAddress gl_address() const override { return platform->address(); }
    int stray_gl_errors() const override
    {
        return earlier_gl_errors + (session ? session->gl_errors : 0);
    }

  private:
    void start();
    void start_session();
    void drop_session();
    void drop_instance();
    void describe();
    void read_events(HeadsetEvents& events);
    void take(const XrEventDataBuffer& event, HeadsetEvents& events);
    bool fulfil(SessionAction duty, HeadsetEvents& events);
    void renew(SessionAction duty, HeadsetEvents& events);
    std::string loss_text(SessionAction duty);
    void give_up(const std::string& why);
    // Runs `what`. An XrFailure marks session or instance as lost, for poll() to renew; returns
    // false.
    template <class Action>
    bool try_to(const Action& what);

    HeadsetOptions options;
    PFN_xrGetInstanceProcAddr entry = nullptr;
    std::unique_ptr<Platform> platform;
    std::unique_ptr<Instance> instance;
    std::unique_ptr<Session> session;
    HeadsetInfo about;
    XrFrameState frame{};
    bool in_frame = false;
    bool moves_floor = false;  // at the next poll()
    bool worn = true, renewed = false, over = false, leaving = false;
    double rate = 0;
    double lost_at = -1;  // time of the loss [s, steady clock]; negative: not lost
    int fruitless = 0;    // sessions created since the last frame submitted
    // Renewal is tried at once, then after pauses that double up to 1 s.
    double pause = 0, next_try = 0;  // [s]; [s, steady clock]
    std::string reason;
    std::string last_loss;      // text of the last failure
    int earlier_gl_errors = 0;  // GL errors of earlier sessions
    // FrameTiming::time = 1e-9 (XrTime - zero) [s].
    bool rebase = true;
    XrTime zero = 0;
    double last_time = 0, last_period = 0;
};

void OpenXrHeadset::start()
{
    entry = loader();
    const std::vector<std::string> offered = offered_extensions(entry);
    // The GL context and everything uploaded to it outlive a lost runtime.
    if (!platform) platform = xr::platform(options.binding, offered);
    instance = std::make_unique<Instance>(entry, offered, platform->extension());
    try {
        start_session();
    } catch (const XrFailure& e) {
        drop_instance();
        throw HeadsetError(std::string("the OpenXR runtime makes no session: ") + e.what());
    }
}

void OpenXrHeadset::start_session()
{
    session = std::make_unique<Session>(*instance, *platform, options);
    if (leaving) session->state.wants_to_leave();
    rate = session->refresh_rate();
    rebase = true;
    describe();
}

void OpenXrHeadset::drop_session()
{
    if (session) earlier_gl_errors += session->gl_errors;
    in_frame = false;
    session.reset();
}

void OpenXrHeadset::drop_instance()
{
    drop_session();
    instance.reset();
}

void OpenXrHeadset::describe()
{
    about.runtime = instance->runtime_name, about.system = instance->system_name;
    about.binding = platform->name();
    const auto text =
        reinterpret_cast<const unsigned char* (*)(unsigned)>(platform->address()("glGetString"));
    const unsigned char* renderer = text(0x1F01);
    about.renderer = renderer ? reinterpret_cast<const char*>(renderer) : "unnamed";
    about.extensions = instance->has.names(), about.missing = instance->has.missing();
    session->describe(about);
    for (int eye = 0; eye < 2; ++eye) about.hidden[std::size_t(eye)] = session->hidden_area(eye);
}

template <class Action>
bool OpenXrHeadset::try_to(const Action& what)
{
    try {
        what();
        return true;
    } catch (const XrFailure& e) {
        last_loss = e.what();
        if (e.code == XR_ERROR_INSTANCE_LOST || e.code == XR_ERROR_RUNTIME_FAILURE) {
            session->state.instance_lost();
        } else {
            // Any other failure is a bug here or in the runtime. A new session may recover from it,
            // and the simulation is kept.
            session->state.session_lost();
        }
        return false;
    }
}

void OpenXrHeadset::give_up(const std::string& why)
{
    over = true;
    reason = why;  // close() frees session and instance
}

void OpenXrHeadset::take(const XrEventDataBuffer& event, HeadsetEvents& events)
{
    SessionState& state = session->state;
    switch (int(event.type)) {
        case XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED:
            state.entered(
                XrState(reinterpret_cast<const XrEventDataSessionStateChanged&>(event).state));
            break;
        case XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING:
            state.instance_lost();
            break;
        case XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING:
            events.recentred = true;
            break;
        case XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB:
            rate = reinterpret_cast<const XrEventDataDisplayRefreshRateChangedFB&>(event)
                       .toDisplayRefreshRate;
            break;
        case XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT:
            worn = reinterpret_cast<const XrEventDataUserPresenceChangedEXT&>(event).isUserPresent;
            break;
        case XR_TYPE_EVENT_DATA_VISIBILITY_MASK_CHANGED_KHR:
            for (int eye = 0; eye < 2; ++eye)
                about.hidden[std::size_t(eye)] = session->hidden_area(eye);
            break;
        case XR_TYPE_EVENT_DATA_EVENTS_LOST:
            events.messages.push_back("the runtime has lost events");
            break;
        default:
            break;
    }
}

void OpenXrHeadset::read_events(HeadsetEvents& events)
{
    try_to([&] {
        XrEventDataBuffer event;
        while (instance->next_event(event)) take(event, events);
    });
    for (std::string& message : instance->take_messages()) events.messages.push_back(message);
}

// One message per loss.
std::string OpenXrHeadset::loss_text(SessionAction duty)
{
    std::ostringstream text;
    text << (duty == SessionAction::renew_session ? "the session was lost"
                                                  : "the runtime was lost");
    if (!last_loss.empty()) text << " (" << last_loss << ")";
    text << "; a new one is waited for, " << options.patience << " s at most";
    if (duty == SessionAction::renew_instance) text << ": " << start_advice();
    return text.str();
}

// Recovers a lost session or instance, one attempt per call, until `patience` is exceeded. The
// simulation is not affected.
void OpenXrHeadset::renew(SessionAction duty, HeadsetEvents& events)
{
    if (lost_at < 0) {
        lost_at = wall();
        events.messages.push_back(loss_text(duty));
    }
    if (wall() < next_try) return sleep_for(std::min(options.nap, next_try - wall()));
    constexpr int most_fruitless = 10;
    constexpr double longest_pause = 1;
    pause = std::clamp(2 * pause, options.nap, longest_pause);
    // The last attempt is at the end of `patience`.
    next_try = std::min(wall() + pause, std::max(wall(), lost_at + options.patience));
    if (++fruitless > most_fruitless && !last_loss.empty())
        return give_up("the headset fails again and again: " + last_loss);
    // Loaders and runtimes print a dozen lines per attempt.
    const QuietStderr quiet(std::getenv("XR_LOADER_DEBUG") == nullptr);
    try {
        if (duty == SessionAction::renew_session && instance) {
            drop_session();
            if (!instance->find_system())
                throw HeadsetError("the headset " + about.system + " is gone");
            start_session();
        } else {
            drop_instance();
            start();
        }
        renewed = true;
        lost_at = -1;
        events.messages.push_back("a new session began");
    } catch (const std::runtime_error& e) {
        drop_session();
        // An absent runtime does not count as a failed session: only `patience` limits the
        // attempts.
        if (dynamic_cast<const XrFailure*>(&e))
            drop_instance();
        else
            --fruitless;
        if (wall() - lost_at >= options.patience)
            give_up(std::string("the headset did not come back: ") + e.what());
    }
}

// Executes the action; false if there was none.
bool OpenXrHeadset::fulfil(SessionAction duty, HeadsetEvents& events)
{
    switch (duty) {
        case SessionAction::nothing:
            return false;
        case SessionAction::begin:
        case SessionAction::end:
            try_to([&] { session->fulfil(duty); });
            return true;
        case SessionAction::renew_session:
        case SessionAction::renew_instance:
            renew(duty, events);
            return true;
        case SessionAction::leave:
            give_up("");
            return true;
    }
    return false;
}

HeadsetEvents OpenXrHeadset::poll()
{
    HeadsetEvents events;
    if (std::exchange(moves_floor, false) && session)
        try_to([&] {
            session->move_origin();
            session->describe(about);
        });
    if (!over && !session) {
        if (leaving)
            give_up("");
        else
            renew(instance ? SessionAction::renew_session : SessionAction::renew_instance, events);
    }
    if (!over && session) {
        read_events(events);
        for (int k = 0; k < 4 && !over && session && fulfil(session->state.duty(), events); ++k)
            if (session) read_events(events);
    }
    events.reason = reason;
    events.worn = worn;
    events.rate = rate;
    if (over) {
        events.phase = Phase::over;
        return events;
    }
    events.renewed = std::exchange(renewed, false);
    events.lost = !session;
    if (!session) return events;
    events.visible = session->state.visible(), events.focused = session->state.focused();
    events.phase = session->state.running() ? Phase::running : Phase::waiting;
    if (events.phase == Phase::waiting) sleep_for(options.nap);
    return events;
}

FrameTiming OpenXrHeadset::begin()
{
    FrameTiming timing;
    timing.time = last_time + last_period, timing.period = last_period;
    in_frame = session && session->state.running() && try_to([&] { frame = session->wait(); });
    if (!in_frame) {
        last_time = timing.time;
        return timing;
    }
    timing.period = 1e-9 * double(frame.predictedDisplayPeriod);
    // A new runtime may use another clock: continue the old time.
    if (rebase) {
        const bool first = last_period == 0;
        const double now = first ? 0 : last_time + last_period;
        zero = frame.predictedDisplayTime - XrTime(std::llround(1e9 * now));
        rebase = false;
    }
    timing.time = 1e-9 * double(frame.predictedDisplayTime - zero);
    timing.draw = frame.shouldRender;
    last_time = timing.time;
    last_period = timing.period > 0 ? timing.period : 1.0 / 90;
    return timing;
}

HeadsetViews OpenXrHeadset::locate()
{
    HeadsetViews views;
    if (in_frame && !try_to([&] { views = session->locate(frame); })) views = {};
    return views;
}

void OpenXrHeadset::end(const FrameSubmission& drawn)
{
    if (in_frame && try_to([&] { session->end(frame, drawn); }))
        fruitless = 0, pause = 0, last_loss.clear();
    in_frame = false;
}

void OpenXrHeadset::leave()
{
    leaving = true;
    if (!session) return;
    session->state.wants_to_leave();
    if (session->state.running()) session->request_exit();
}

double OpenXrHeadset::time_left()
{
#ifndef _WIN32
    if (!in_frame || !instance->has[convert_time]) return -1;
    timespec seen{}, now{};
    if (XR_FAILED(instance->api.to_timespec.raw(instance->api.instance, frame.predictedDisplayTime,
                                                &seen)))
        return -1;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return double(seen.tv_sec - now.tv_sec) + 1e-9 * double(seen.tv_nsec - now.tv_nsec);
#else
    return -1;
#endif
}

void OpenXrHeadset::close()
{
    over = true;
    drop_instance();
}

}  // namespace
}  // namespace xr

std::unique_ptr<Headset> Headset::open(const HeadsetOptions& options)
{
    return std::make_unique<xr::OpenXrHeadset>(options);
}

}  // namespace knead
