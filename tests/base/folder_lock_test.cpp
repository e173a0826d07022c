// One process at a time writes into a folder, whatever ends it.
#include "host/base/folder_lock.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "host/base/errors.h"
#include "host/base/outputs.h"
#include "tests/folder.h"
#include "tests/reason.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

class FolderLocks : public InFolder {};

// A process that has done `action` and waits until it is killed.
class Other {
  public:
    template <class Action>
    explicit Other(Action&& action)
    {
        int ready[2];
        EXPECT_EQ(pipe(ready), 0);
        process = fork();
        if (process == 0) {
            action();
            if (write(ready[1], "x", 1) != 1) _exit(1);
            for (;;) pause();
        }
        char byte = 0;
        EXPECT_EQ(read(ready[0], &byte, 1), 1);
        close(ready[0]), close(ready[1]);
    }
    Other(const Other&) = delete;
    ~Other() { kill_it(); }
    void kill_it()
    {
        if (process <= 0) return;
        kill(process, SIGKILL);
        waitpid(process, nullptr, 0);
        process = 0;
    }
    pid_t process;
};

TEST_F(FolderLocks, AFolderIsOneProcessesUntilItEndsHoweverItEnds)
{
    const std::string place = path("out");
    const auto why = [&] {
        return reason<OutputError>([&] {
            const FolderLock lock = prepare_folder(place, {"report.json"}, true);
            EXPECT_TRUE(lock.held());
        });
    };
    fs::create_directory(place);
    {
        Other other([&] { new FolderLock(prepare_folder(place, {}, false)); });
        EXPECT_EQ(why(),
                  place + ": process " + std::to_string(other.process) +
                      " is writing there; wait until it has ended, or choose another folder");
        EXPECT_TRUE(leftovers(place).empty()) << "a lock that is held";
        EXPECT_EQ(reason<OutputError>([&] { FolderLock(place, "orbit"); }), "");
        other.kill_it();
    }
    const std::vector<Leftover> left = leftovers(place);
    ASSERT_EQ(left.size(), 1u);
    EXPECT_EQ(left[0].path, (fs::path(place) / lock_name).string());
    EXPECT_EQ(left[0].of, lock_name);
    EXPECT_EQ(why(), "");
    EXPECT_TRUE(fs::is_empty(place));

    FolderLock mine(place), moved(std::move(mine));
    EXPECT_FALSE(mine.held());
    EXPECT_NE(why(), "") << "another lock of the same process";
    {
        const FolderLock kept = prepare_folder(place, {}, false, std::move(moved));
        EXPECT_TRUE(kept.held());
        EXPECT_NE(why(), "");
    }
    EXPECT_EQ(why(), "");
    EXPECT_TRUE(fs::is_empty(place));
}

TEST_F(FolderLocks, ASetOfFilesIsLockedByItsName)
{
    const std::string long_name(251, 'n');
    for (const std::string& set : {std::string("orbit"), long_name}) {
        const FolderLock lock(folder.string(), set);
        EXPECT_TRUE(lock.held());
        EXPECT_NE(reason<OutputError>([&] { FolderLock(folder.string(), set); }), "");
        EXPECT_EQ(reason<OutputError>([&] { FolderLock(folder.string(), "other"); }), "");
    }
    EXPECT_EQ(files(), 0);
}

// Of many that want it at the same time one has it at a time, and none is left over.
TEST_F(FolderLocks, OneOfManyHasTheLock)
{
    std::atomic<int> now = 0, had = 0;
    std::vector<std::thread> all;
    for (int k = 0; k < 8; ++k)
        all.emplace_back([&] {
            for (int i = 0; i < 50; ++i) try {
                    const FolderLock lock(folder.string());
                    EXPECT_EQ(++now, 1);
                    ++had, --now;
                } catch (const OutputError&) {
                }
        });
    for (std::thread& one : all) one.join();
    EXPECT_GT(had, 0);
    EXPECT_EQ(files(), 0);
}

}  // namespace
}  // namespace knead
