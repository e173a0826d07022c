// Sound as it is made, through OpenAL, which is found at run time.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace knead {

class SoundOut {
  public:
    // Pairs of samples, 48 000 a second. Null, and why, where nothing can be heard.
    static std::unique_ptr<SoundOut> open(std::string& why);
    virtual ~SoundOut() = default;
    // Asks for as many pairs, left and right, as are wanted by now; to be called every frame. About
    // 40 ms lie between them and the ear. Where calls stay away it is silent, and goes on later.
    using Make = std::function<void(int pairs, std::vector<std::int16_t>& to)>;
    virtual void fill(const Make& make) = 0;
};

}  // namespace knead
