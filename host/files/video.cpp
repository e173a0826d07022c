// Videos by ffmpeg as a separate process. Frames are sent through a socket pair instead of a pipe:
// MSG_NOSIGNAL suppresses SIGPIPE if ffmpeg has ended.
#include "host/files/video.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <stdexcept>

#include "host/base/errors.h"
#include "host/base/outputs.h"

extern char** environ;

namespace knead {
namespace {

// A file descriptor, closed on destruction.
class Descriptor {
  public:
    explicit Descriptor(int number = -1) : number_(number) {}
    ~Descriptor() { close(); }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    void close()
    {
        if (number_ >= 0) ::close(number_);
        number_ = -1;
    }
    int number() const { return number_; }

  private:
    int number_;
};

std::string all_of(int descriptor)
{
    std::string text;
    char block[4096];
    ::lseek(descriptor, 0, SEEK_SET);
    for (ssize_t n; (n = ::read(descriptor, block, sizeof block)) > 0;)
        text.append(block, size_t(n));
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
    if (text.size() > 2000) text = "... " + text.substr(text.size() - 2000);
    return text;
}

class Ffmpeg final : public Video {
  public:
    Ffmpeg(const std::string& path, int width, int height, double rate)
        : path_(path),
          partial_(std::make_unique<PartialFile>(path)),
          width_(width),
          height_(height),
          messages_(::memfd_create("ffmpeg messages", MFD_CLOEXEC))
    {
        start(rate);
    }

    // An interrupted video keeps the frames written so far.
    ~Ffmpeg() override
    {
        try {
            close();
        } catch (const std::exception&) {
        }
    }

    void add(const Image& image) override
    {
        if (!frames_) fail("it is closed already");
        const std::size_t bytes = std::size_t(3) * std::size_t(width_) * std::size_t(height_);
        if (image.width != width_ || image.height != height_ || image.rgb.size() != bytes) {
            throw std::invalid_argument("video " + path_ + ": frames are " +
                                        std::to_string(width_) + " x " + std::to_string(height_) +
                                        ", but this one is " + std::to_string(image.width) + " x " +
                                        std::to_string(image.height));
        }
        for (std::size_t sent = 0; sent < bytes;) {
            const ssize_t n =
                ::send(frames_->number(), image.rgb.data() + sent, bytes - sent, MSG_NOSIGNAL);
            if (n < 0 && errno == EINTR) continue;
            if (n < 0) return close();  // ffmpeg has ended: close() throws with the reason
            sent += std::size_t(n);
        }
    }

    void close() override
    {
        if (!frames_) return;
        frames_.reset();
        int status = 0;
        while (::waitpid(process_, &status, 0) < 0) {
            if (errno != EINTR) fail(std::string("waiting for ffmpeg: ") + std::strerror(errno));
        }
        if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
            partial_->put_in_place();
            partial_.reset();
            return;
        }
        partial_.reset();
        const std::string said = all_of(messages_.number());
        if (!said.empty()) fail("ffmpeg says: " + said);
        if (WIFSIGNALED(status)) fail("ffmpeg ended by signal " + std::to_string(WTERMSIG(status)));
        fail("ffmpeg ended with status " + std::to_string(WEXITSTATUS(status)));
    }

  private:
    [[noreturn]] void fail(const std::string& reason) const
    {
        throw OutputError(path_ + ": the video cannot be written: " + reason);
    }

    void start(double rate)
    {
        int pair[2];
        if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) != 0) {
            fail(std::strerror(errno));
        }
        frames_ = std::make_unique<Descriptor>(pair[0]);
        const Descriptor theirs(pair[1]);
        std::ostringstream rate_text;
        rate_text << rate;
        // "file:" prevents paths from being parsed as options or URLs. Players require 4:2:0, which
        // requires even sides. Without -xerror a full disk at the end would not be an error.
        std::vector<std::string> words = {"ffmpeg",
                                          "-hide_banner",
                                          "-loglevel",
                                          "error",
                                          "-xerror",
                                          "-y",
                                          "-f",
                                          "rawvideo",
                                          "-pix_fmt",
                                          "rgb24",
                                          "-video_size",
                                          std::to_string(width_) + "x" + std::to_string(height_),
                                          "-framerate",
                                          rate_text.str(),
                                          "-i",
                                          "pipe:0",
                                          "-an",
                                          "-vf",
                                          "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                                          "-pix_fmt",
                                          "yuv420p",
                                          "file:" + partial_->path()};
        std::vector<char*> argv;
        argv.reserve(words.size() + 1);
        for (std::string& word : words) argv.push_back(word.data());
        argv.push_back(nullptr);
        spawn(argv.data(), theirs.number());
    }

    void spawn(char** argv, int input)
    {
        posix_spawn_file_actions_t files;
        posix_spawn_file_actions_init(&files);
        posix_spawn_file_actions_adddup2(&files, input, 0);
        posix_spawn_file_actions_addopen(&files, 1, "/dev/null", O_WRONLY, 0);
        posix_spawn_file_actions_adddup2(&files, messages_.number(), 2);
        posix_spawnattr_t how;
        posix_spawnattr_init(&how);
        // Own process group: Ctrl-C interrupts this process only; ffmpeg ends when its input ends.
        posix_spawnattr_setflags(&how, POSIX_SPAWN_SETPGROUP);
        const int error = ::posix_spawnp(&process_, argv[0], &files, &how, argv, environ);
        posix_spawnattr_destroy(&how);
        posix_spawn_file_actions_destroy(&files);
        if (error == 0) return;
        frames_.reset();
        partial_.reset();
        fail(std::string("ffmpeg does not start: ") + std::strerror(error));
    }

    std::string path_;
    std::unique_ptr<PartialFile> partial_;  // written by ffmpeg
    int width_, height_;
    Descriptor messages_;  // ffmpeg's stderr; in memory, so it never blocks
    std::unique_ptr<Descriptor> frames_;
    pid_t process_ = -1;
};

}  // namespace

bool Video::available()
{
    const char* path = std::getenv("PATH");
    std::istringstream folders(path ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');) {
        if (::access(((folder.empty() ? "." : folder) + "/ffmpeg").c_str(), X_OK) == 0) return true;
    }
    return false;
}

std::unique_ptr<Video> Video::open(const std::string& path, int width, int height, double rate)
{
    if (width < 1 || height < 1 || width > 16384 || height > 16384) {
        throw std::invalid_argument("video " + path + ": frames of " + std::to_string(width) +
                                    " x " + std::to_string(height) +
                                    " pixels; expected 1 to 16384");
    }
    if (!(rate > 0 && rate <= 1000)) {
        throw std::invalid_argument("video " + path + ": " + std::to_string(rate) +
                                    " frames per second; expected more than 0, at most 1000");
    }
    if (!available()) {
        throw OutputError(path + ": the video cannot be written: ffmpeg is not on the PATH");
    }
    return std::make_unique<Ffmpeg>(path, width, height, rate);
}

}  // namespace knead
