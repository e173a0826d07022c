// Calls into foreign code that may never return (a driver, a runtime, its service), made on a
// thread that the program can abandon.
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>

namespace knead {

// Guards the state of a worker thread that makes such calls. The worker holds the gate except
// during call_unlocked(); another thread can enter() while a call is in progress and use that
// state. A worker whose call returns waits until the other thread leaves the gate.
class CallGate {
  public:
    CallGate() = default;
    CallGate(const CallGate&) = delete;

    // On the worker: around all of its work.
    void begin() { lock.lock(); }
    void end() { lock.unlock(); }

    // On the worker: makes a call that may never return. `watched`: include it in blocked().
    template <class Call>
    decltype(auto) call_unlocked(bool watched, const Call& call)
    {
        const Unlocked made(*this, watched);
        return call();
    }
    // Duration of the watched call in progress [s]; 0: none. Thread-safe.
    double blocked() const;

    // On another thread: returns true once it holds the gate; false after `seconds` without a call.
    bool enter(double seconds);
    void leave() { lock.unlock(); }

  private:
    class Unlocked {
      public:
        Unlocked(CallGate& gate, bool watched);
        ~Unlocked();
        Unlocked(const Unlocked&) = delete;

      private:
        CallGate& gate;
    };

    std::timed_mutex lock;
    std::atomic<double> since = 0;  // wall_seconds() at the start of the call in progress; 0: none
};

// A thread that is joined if its work ends in time, and abandoned otherwise.
class AbandonableThread {
  public:
    // Precondition: `work` owns all that it uses and does not throw. It is destroyed on the thread.
    explicit AbandonableThread(std::function<void()> work);
    ~AbandonableThread();  // abandons unfinished work; finished_within(0)
    AbandonableThread(const AbandonableThread&) = delete;

    bool finished_within(double seconds);

  private:
    struct State;
    std::shared_ptr<State> state;
};

// Returns the exit code for main. If a thread was abandoned, exits immediately instead, without
// destroying static objects that the thread may be using.
int end_of_process(int code);

}  // namespace knead
