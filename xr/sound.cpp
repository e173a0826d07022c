#include "xr/sound.h"

#include <array>

#include "xr/platform.h"

namespace knead {
namespace xr {
namespace {

constexpr const char* libraries = "libopenal.so.1 libopenal.so soft_oal.dll OpenAL32.dll";

// The functions of OpenAL 1.1 in use; names and constants as in its specification.
struct OpenAl {
    void* (*open_device)(const char*) = nullptr;
    char (*close_device)(void*) = nullptr;
    void* (*create_context)(void*, const int*) = nullptr;
    char (*make_current)(void*) = nullptr;
    void (*destroy_context)(void*) = nullptr;
    void (*gen_sources)(int, unsigned*) = nullptr;
    void (*delete_sources)(int, const unsigned*) = nullptr;
    void (*gen_buffers)(int, unsigned*) = nullptr;
    void (*delete_buffers)(int, const unsigned*) = nullptr;
    void (*buffer_data)(unsigned, int, const void*, int, int) = nullptr;
    void (*queue)(unsigned, int, const unsigned*) = nullptr;
    void (*unqueue)(unsigned, int, unsigned*) = nullptr;
    void (*get_source)(unsigned, int, int*) = nullptr;
    void (*play)(unsigned) = nullptr;
    void (*stop)(unsigned) = nullptr;
    int (*error)() = nullptr;
};
constexpr int stereo_16 = 0x1103, source_state = 0x1010, playing = 0x1012, processed = 0x1016;

template <class Function>
bool find_in(const char* names, Function& to, const char* name, std::string& why)
{
    to = reinterpret_cast<Function>(function_of_library(names, name, why));
    return to != nullptr;
}

template <class Function>
bool find(Function& to, const char* name, std::string& why)
{
    return find_in(libraries, to, name, why);
}

bool load(OpenAl& al, std::string& why)
{
    return find(al.open_device, "alcOpenDevice", why) &&
           find(al.close_device, "alcCloseDevice", why) &&
           find(al.create_context, "alcCreateContext", why) &&
           find(al.make_current, "alcMakeContextCurrent", why) &&
           find(al.destroy_context, "alcDestroyContext", why) &&
           find(al.gen_sources, "alGenSources", why) &&
           find(al.delete_sources, "alDeleteSources", why) &&
           find(al.gen_buffers, "alGenBuffers", why) &&
           find(al.delete_buffers, "alDeleteBuffers", why) &&
           find(al.buffer_data, "alBufferData", why) &&
           find(al.queue, "alSourceQueueBuffers", why) &&
           find(al.unqueue, "alSourceUnqueueBuffers", why) &&
           find(al.get_source, "alGetSourcei", why) && find(al.play, "alSourcePlay", why) &&
           find(al.stop, "alSourceStop", why) && find(al.error, "alGetError", why);
}

void silence(const char*, int, const char*, int, const char*, ...) {}

// ALSA, the backend of OpenAL, writes half a page to stderr if there is no sound card. This
// silences it; open() reports the error in one sentence.
void quiet_alsa()
{
    using Print = void (*)(const char*, int, const char*, int, const char*, ...);
    std::string missing;
    int (*print_by)(Print) = nullptr;
    if (find_in("libasound.so.2", print_by, "snd_lib_error_set_handler", missing))
        print_by(silence);
}

class OpenAlOut final : public SoundOut {
  public:
    explicit OpenAlOut(const OpenAl& with) : al(with) {}
    ~OpenAlOut() override
    {
        if (context) {
            if (source) al.stop(source), al.delete_sources(1, &source);
            if (buffers[0]) al.delete_buffers(int(buffers.size()), buffers.data());
            al.make_current(nullptr);
            al.destroy_context(context);
        }
        if (device) al.close_device(device);
    }
    bool start(std::string& why);
    void fill(const Make& make) override;

  private:
    static constexpr int pairs = 512, rate = 48000;
    OpenAl al;
    void *device = nullptr, *context = nullptr;
    unsigned source = 0;
    std::array<unsigned, 4> buffers{};
    std::vector<unsigned> free;
    std::vector<std::int16_t> samples;
};

bool OpenAlOut::start(std::string& why)
{
    device = al.open_device(nullptr);
    if (!device) return why = "OpenAL finds no device to play on", false;
    context = al.create_context(device, nullptr);
    if (context && al.make_current(context)) {
        al.error();
        al.gen_sources(1, &source);
        al.gen_buffers(int(buffers.size()), buffers.data());
        free.assign(buffers.begin(), buffers.end());
        if (al.error() == 0) return true;
    }
    return why = "OpenAL does not play", false;
}

void OpenAlOut::fill(const Make& make)
{
    int done = 0;
    al.get_source(source, processed, &done);
    for (; done > 0; --done) {
        unsigned name = 0;
        al.unqueue(source, 1, &name);
        if (name) free.push_back(name);
    }
    for (; !free.empty(); free.pop_back()) {
        samples.clear();
        make(pairs, samples);
        al.buffer_data(free.back(), stereo_16, samples.data(),
                       int(samples.size() * sizeof samples[0]), rate);
        al.queue(source, 1, &free.back());
    }
    int state = 0;
    al.get_source(source, source_state, &state);
    if (state != playing) al.play(source);
    al.error();
}

}  // namespace
}  // namespace xr

std::unique_ptr<SoundOut> SoundOut::open(std::string& why)
{
    xr::OpenAl al;
    if (!xr::load(al, why)) return nullptr;
    xr::quiet_alsa();
    auto made = std::make_unique<xr::OpenAlOut>(al);
    if (!made->start(why)) return nullptr;
    return made;
}

}  // namespace knead
