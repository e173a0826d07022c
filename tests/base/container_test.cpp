// Limits of control groups, read from files as kernels, Docker and systemd make them.
#include "host/base/container.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>

#include "host/base/machine.h"
#include "tests/folder.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

constexpr std::size_t MiB = 1 << 20;

class Container : public InFolder {
  protected:
    void put(const std::string& name, const std::string& text) const
    {
        fs::create_directories((folder / name).parent_path());
        std::ofstream(folder / name) << text;
    }
    void put(const std::string& name, std::size_t number) const
    {
        put(name, std::to_string(number) + "\n");
    }
    void version_2(const std::string& group, const std::string& mounted = "/") const
    {
        put("proc/self/cgroup", "0::" + group + "\n");
        put("proc/self/mountinfo",
            "22 1 8:1 / / rw - ext4 /dev/sda1 rw\n"
            "30 23 0:26 " +
                mounted + " /sys/fs/cgroup rw,nosuid shared:4 - cgroup2 cgroup2 rw\n");
    }
    void version_1(const std::string& group, const std::string& mounted = "/") const
    {
        put("proc/self/cgroup", "5:cpu,cpuacct:" + group + "\n4:memory:" + group + "\n0::/\n");
        put("proc/self/mountinfo",
            "31 23 0:28 / /sys/fs/cgroup rw - tmpfs tmpfs rw,mode=755\n"
            "32 31 0:29 " +
                mounted +
                " /sys/fs/cgroup/cpu,cpuacct rw - cgroup cgroup rw,cpu,cpuacct\n"
                "35 31 0:32 " +
                mounted +
                " /sys/fs/cgroup/memory rw shared:9 - cgroup cgroup rw,memory\n"
                "41 31 0:38 / /sys/fs/cgroup/unified rw - cgroup2 cgroup2 rw\n");
    }
    ContainerLimits limits() const { return container_limits(folder.string()); }
};

TEST_F(Container, WithoutGroupsThereIsNoLimit)
{
    EXPECT_FALSE(limits().memory || limits().free || limits().cpus);
    put("proc/self/cgroup", "");
    put("proc/self/mountinfo", "nonsense\n - \n");
    EXPECT_FALSE(limits().memory || limits().free || limits().cpus);
}

TEST_F(Container, Version2HasTheLeastLimitOfAllGroupsAbove)
{
    version_2("/user.slice/job.scope");
    const std::string top = "sys/fs/cgroup/", job = top + "user.slice/job.scope/";
    put(job + "memory.max", "max\n");
    put(job + "memory.high", "max\n");
    put(job + "cpu.max", "max 100000\n");
    EXPECT_FALSE(limits().memory || limits().free || limits().cpus);

    put(job + "memory.max", 900 * MiB);
    put(job + "memory.current", 500 * MiB);
    put(job + "memory.stat", "anon 1\nfile 2\ninactive_file 104857600\nactive_file 52428800\n");
    EXPECT_EQ(limits().memory, 900 * MiB);
    EXPECT_EQ(limits().free, (900 - (500 - 100 - 50)) * MiB);

    put(top + "user.slice/memory.max", 700 * MiB);
    put(top + "user.slice/memory.current", 650 * MiB);
    EXPECT_EQ(limits().memory, 700 * MiB);
    EXPECT_EQ(limits().free, 50 * MiB);

    put(job + "memory.high", 100 * MiB);  // it is slowed down above
    EXPECT_EQ(limits().memory, 100 * MiB);
    EXPECT_EQ(limits().free, 0u);

    put(job + "cpu.max", "150000 100000\n");
    put(top + "user.slice/cpu.max", "400000 100000\n");
    EXPECT_EQ(limits().cpus, 1.5);
}

// Of a container, what appears is its own group, by a name of its own or by the host's.
TEST_F(Container, TheGroupIsFoundWhereverItIsMounted)
{
    const std::string top = "sys/fs/cgroup/";
    put(top + "memory.max", 512 * MiB);
    version_2("/");
    EXPECT_EQ(limits().memory, 512 * MiB);
    version_2("/docker/abc", "/docker/abc");
    EXPECT_EQ(limits().memory, 512 * MiB);
    version_2("/docker/abc/inner", "/docker/abc");
    EXPECT_EQ(limits().memory, 512 * MiB);
    put(top + "inner/memory.max", 256 * MiB);
    EXPECT_EQ(limits().memory, 256 * MiB);
    version_2("/docker/abcinner", "/docker/abc");
    EXPECT_EQ(limits().memory, 512 * MiB) << "another group, whose name begins so";
    version_2("/../other");
    EXPECT_EQ(limits().memory, 512 * MiB);
}

TEST_F(Container, Version1IsReadByItsControllers)
{
    const std::string memory = "sys/fs/cgroup/memory/", cpu = "sys/fs/cgroup/cpu,cpuacct/";
    version_1("/docker/abc");
    put(memory + "memory.limit_in_bytes", std::size_t(9223372036854771712u));
    put(memory + "docker/memory.limit_in_bytes", std::size_t(9223372036854771712u));
    put(memory + "docker/abc/memory.limit_in_bytes", std::size_t(9223372036854771712u));
    put(cpu + "docker/abc/cpu.cfs_quota_us", "-1\n");
    put(cpu + "docker/abc/cpu.cfs_period_us", "100000\n");
    EXPECT_FALSE(limits().memory || limits().free || limits().cpus);

    put(memory + "docker/abc/memory.limit_in_bytes", 300 * MiB);
    put(memory + "docker/abc/memory.usage_in_bytes", 200 * MiB);
    put(memory + "docker/abc/memory.stat", "inactive_file 1\ntotal_inactive_file 104857600\n");
    put(cpu + "docker/abc/cpu.cfs_quota_us", "250000\n");
    EXPECT_EQ(limits().memory, 300 * MiB);
    EXPECT_EQ(limits().free, 200 * MiB);
    EXPECT_EQ(limits().cpus, 2.5);

    put(memory + "docker/memory.limit_in_bytes", 250 * MiB);
    put(memory + "docker/memory.usage_in_bytes", 240 * MiB);
    EXPECT_EQ(limits().memory, 250 * MiB);
    EXPECT_EQ(limits().free, 10 * MiB);
    put(memory + "docker/abc/memory.use_hierarchy", "0\n");
    EXPECT_EQ(limits().memory, 250 * MiB);
    put(memory + "docker/memory.use_hierarchy", "0\n");
    EXPECT_EQ(limits().memory, 300 * MiB);

    version_1("/docker/xyz", "/docker/xyz");  // as Docker mounts it
    put(memory + "memory.limit_in_bytes", 123 * MiB);
    EXPECT_EQ(limits().memory, 123 * MiB);
}

TEST_F(Container, TheMachineHasNoMoreThanItsContainer)
{
    const ContainerLimits here = container_limits();
    EXPECT_GT(total_memory(), 0u);
    EXPECT_LE(available_memory(), total_memory());
    EXPECT_LE(total_memory(), here.memory.value_or(SIZE_MAX));
    EXPECT_LT(cpu_count(), here.cpus.value_or(1e9) + 1);
}

}  // namespace
}  // namespace knead
