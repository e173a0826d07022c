// A disk that runs full while it lives: no file grows beyond so many bytes.
#pragma once
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

namespace knead {

class SmallDisk {
  public:
    explicit SmallDisk(rlim_t bytes)
    {
        EXPECT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
        signal_before = std::signal(SIGXFSZ, SIG_IGN);
        const rlimit small{bytes, before.rlim_max};
        EXPECT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    }
    SmallDisk(const SmallDisk&) = delete;
    ~SmallDisk()
    {
        setrlimit(RLIMIT_FSIZE, &before);
        std::signal(SIGXFSZ, signal_before);
    }

  private:
    rlimit before{};
    void (*signal_before)(int) = SIG_DFL;
};

}  // namespace knead
