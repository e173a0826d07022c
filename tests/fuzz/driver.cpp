// Fuzzing without libFuzzer: the seeds of each format, then changes of them, a fixed number drawn
// from a fixed seed. The input under test lies in a file, so that it is there whatever ends the
// program: a fault, a sanitizer, more than 20 s of the processor, or more memory than 2 GiB.
// usage: knead_fuzz [--inputs N] [--seed S] [--seconds T] [--keep FILE] [--seeds FOLDER]
// [FORMAT...]
//        knead_fuzz --replay FORMAT FILE... | --list
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "tests/fuzz/formats.h"
#include "tests/fuzz/mutate.h"

// Read by the sanitizers before main.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options()
{
    return "max_allocation_size_mb=1024:hard_rss_limit_mb=3000:abort_on_error=0";
}

namespace knead {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t longest = 1 << 20;

struct Options {
    long inputs = 200;
    double seconds = 0;  // per format, in place of `inputs`; 0: none
    std::uint64_t seed = 1;
    std::string keep, seeds;
    bool replay = false, list = false;
    std::vector<std::string> words;  // formats; after --replay a format and its files
};

Options options_of(int count, char** words)
{
    Options o;
    for (int i = 1; i < count; ++i) {
        const std::string word = words[i];
        const auto next = [&] { return std::string(i + 1 < count ? words[++i] : "0"); };
        if (word == "--inputs")
            o.inputs = std::stol(next());
        else if (word == "--seconds")
            o.seconds = std::stod(next());
        else if (word == "--seed")
            o.seed = std::stoull(next());
        else if (word == "--keep")
            o.keep = next();
        else if (word == "--seeds")
            o.seeds = next();
        else if (word == "--replay")
            o.replay = true;
        else if (word == "--list")
            o.list = true;
        else
            o.words.push_back(word);
    }
    if (o.keep.empty())
        o.keep = (fs::temp_directory_path() / fmt::format("knead-fuzz-{}", getpid())).string();
    return o;
}

// The input under test, in memory that is a file's.
class Kept {
  public:
    explicit Kept(const std::string& at) : path(at)
    {
        file = open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC, 0666);
        if (file < 0) throw std::runtime_error(path + ": cannot be written");
        void* const memory = mmap(nullptr, longest, PROT_WRITE, MAP_SHARED, file, 0);
        if (memory == MAP_FAILED) throw std::runtime_error(path + ": cannot be mapped");
        at_input = static_cast<char*>(memory);
    }
    void set(const std::string& input)
    {
        if (ftruncate(file, off_t(input.size())) != 0)
            throw std::runtime_error(path + ": cannot be written");
        std::memcpy(at_input, input.data(), input.size());
    }
    void forget()
    {
        munmap(at_input, longest);
        close(file);
        unlink(path.c_str());
    }

  private:
    const std::string path;
    int file = -1;
    char* at_input = nullptr;
};

// An input may take so long; then the signal's own action ends the program.
void allow_seconds(int seconds)
{
    const itimerval limit{{0, 0}, {seconds, 0}};
    setitimer(ITIMER_PROF, &limit, nullptr);
}

// Whether it was read; false: refused.
bool was_read(const FuzzFormat& format, const std::string& input)
{
    allow_seconds(20);
    try {
        format.read(input);
        return true;
    } catch (const InputError&) {
        return false;
    }
}

// What libFuzzer found to run other lines, a few of each format; in the order of their names.
std::vector<std::string> found_inputs(const FuzzFormat& format)
{
    std::vector<fs::path> files;
    const fs::path folder = fs::path("tests/fuzz/corpus") / format.name;
    if (!fs::is_directory(folder))
        throw std::logic_error(folder.string() + ": not here; run from the top of the tree");
    for (const auto& file : fs::directory_iterator(folder)) files.push_back(file.path());
    std::sort(files.begin(), files.end());
    std::vector<std::string> inputs;
    for (const fs::path& file : files) inputs.push_back(read_text(file.string(), longest));
    return inputs;
}

// Throws what the format throws.
void fuzz(const FuzzFormat& format, const Options& o, Kept& kept)
{
    allow_seconds(0);
    std::vector<std::string> seeds = format.seeds();
    for (std::size_t i = 0; i < seeds.size(); ++i) {
        kept.set(seeds[i]);
        if (!was_read(format, seeds[i]))
            throw std::logic_error(fmt::format("its seed {} is refused", i));
    }
    for (const std::string& input : found_inputs(format)) {
        kept.set(input);
        was_read(format, input);
        seeds.push_back(input);
    }
    Mutator mutator(o.seed);
    const auto begin = std::chrono::steady_clock::now();
    const auto over = [&](long done) {
        if (o.seconds <= 0) return done >= o.inputs;
        const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
        return took.count() >= o.seconds;
    };
    long read = 0, done = 0;
    for (; !over(done); ++done) {
        const std::string input = mutator.changed(seeds, longest);
        kept.set(input);
        read += was_read(format, input);
    }
    std::printf("%-14s %zu seeds, %ld inputs: %ld read, %ld refused\n", format.name, seeds.size(),
                done, read, done - read);
    std::fflush(stdout);
    // Where all or none come through, the changes test nothing.
    if (done >= 100 && (read == 0 || read == done))
        throw std::logic_error("all of its inputs came to the same end");
}

void write_seeds(const FuzzFormat& format, const std::string& folder)
{
    const fs::path own = fs::path(folder) / format.name;
    fs::create_directories(own);
    int number = 0;
    for (const std::string& seed : format.seeds())
        write_whole((own / fmt::format("seed-{}", number++)).string(), seed);
}

void replay(const FuzzFormat& format, const Options& o)
{
    for (std::size_t i = 1; i < o.words.size(); ++i)
        std::printf("%s: %s\n", o.words[i].c_str(),
                    was_read(format, read_text(o.words[i], longest)) ? "read" : "refused");
}

int run(const Options& o)
{
    int found = 0;
    for (const FuzzFormat& format : fuzz_formats()) {
        bool selected = o.words.empty();
        for (const std::string& word : o.words) selected |= word == format.name;
        if (!selected) continue;
        ++found;
        if (o.list) {
            std::printf("%s\n", format.name);
        } else if (o.replay) {
            replay(format, o);
        } else if (!o.seeds.empty()) {
            write_seeds(format, o.seeds);
        } else {
            Kept kept(o.keep);
            try {
                fuzz(format, o, kept);
            } catch (const std::exception& e) {
                std::printf("%s: %s: the input is in %s\n", format.name, e.what(), o.keep.c_str());
                return 1;
            }
            kept.forget();
        }
    }
    if (found > 0) return 0;
    std::printf("no such format\n");
    return 2;
}

}  // namespace
}  // namespace knead

int main(int count, char** words)
{
    const knead::Options options = knead::options_of(count, words);
#if !defined(__SANITIZE_ADDRESS__) && !defined(KNEAD_SANITIZED)
    const rlimit most{rlim_t(2) << 30, rlim_t(2) << 30};
    setrlimit(RLIMIT_AS, &most);
#endif
    return knead::run(options);
}
