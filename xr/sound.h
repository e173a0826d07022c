// Streamed sound output by OpenAL, loaded at run time.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace knead {

class SoundOut {
  public:
    // Opens stereo output at 48 000 Hz. Returns null and sets `why` if there is none.
    static std::unique_ptr<SoundOut> open(std::string& why);
    virtual ~SoundOut() = default;
    // Call every frame. Calls `make` for each free buffer, to append `pairs` pairs of samples
    // (left, right). Latency about 40 ms. Without calls the output falls silent; the next call
    // resumes it.
    using Make = std::function<void(int pairs, std::vector<std::int16_t>& to)>;
    virtual void fill(const Make& make) = 0;
};

}  // namespace knead
