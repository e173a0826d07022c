// How soon what may be given up is given up: the time from one question to the next.
#pragma once
#include <time.h>

#include <algorithm>
#include <functional>

namespace knead {

class Asks {
  public:
    // To be asked by the thread that made this: true from the n-th time on.
    std::function<bool()> until(int n)
    {
        count = 0, longest = 0, before = now();
        return [this, n] { return note(), ++count >= n; };
    }
    // The processor's seconds from the start to the first question, from one to the next or, if it
    // is longer, from the last until now.
    double longest_wait() { return note(), longest; }

    int count = 0;

  private:
    static double now()
    {
        timespec t{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
        return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
    }
    void note()
    {
        const double at = now();
        longest = std::max(longest, at - before), before = at;
    }

    double before = now(), longest = 0;
};

}  // namespace knead
