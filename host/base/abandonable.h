// Calls into foreign code that may never return (a driver, a runtime, its service): made by a
// thread that the rest of the program can go on without.
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>

namespace knead {

// Guards the state of a worker thread that makes such calls. The worker holds the gate at all times
// except during outside(), so another thread may enter() while a call is under way, and use that
// state. A worker that returns from its call waits until the gate is left.
class CallGate {
  public:
    CallGate() = default;
    CallGate(const CallGate&) = delete;

    // The worker, for all of its work.
    void begin() { lock.lock(); }
    void end() { lock.unlock(); }

    // The worker: makes a call that may never return. `watched`: it counts for blocked().
    template <class Call>
    decltype(auto) outside(bool watched, const Call& call)
    {
        const Outside made(*this, watched);
        return call();
    }
    // Seconds since the watched call under way began; 0: there is none. Any thread.
    double blocked() const;

    // Another thread: true once it holds the gate; false if the worker made no call for `seconds`.
    bool enter(double seconds);
    void leave() { lock.unlock(); }

  private:
    class Outside {
      public:
        Outside(CallGate& gate, bool watched);
        ~Outside();
        Outside(const Outside&) = delete;

      private:
        CallGate& gate;
    };

    std::timed_mutex lock;
    std::atomic<double> since = 0;  // wall_seconds() of the call under way; 0: none
};

// A thread that is joined if its work ends in time, and abandoned otherwise.
class AbandonableThread {
  public:
    // `work` must own all that it uses, and must not throw. It is destroyed by the thread.
    explicit AbandonableThread(std::function<void()> work);
    ~AbandonableThread();  // abandons work that has not ended; finished_within(0)
    AbandonableThread(const AbandonableThread&) = delete;

    bool finished_within(double seconds);

  private:
    struct State;
    std::shared_ptr<State> state;
};

// What the process returns from main. Where a thread was abandoned it ends here instead: static
// objects that the thread may be using are then not destroyed.
int end_of_process(int code);

}  // namespace knead
