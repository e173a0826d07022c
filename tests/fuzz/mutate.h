// Changes of a valid input, drawn from a seed: the same on every machine.
#pragma once
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace knead {

class Mutator {
  public:
    explicit Mutator(std::uint64_t seed) : engine(seed) {}

    // One of the inputs with one to six changes: bits, fields of extreme numbers, cut ends, pieces
    // taken out, doubled or brought from another input, numbers and words of a text. At most
    // `longest` bytes.
    std::string changed(const std::vector<std::string>& inputs, std::size_t longest);

  private:
    std::size_t below(std::size_t n) { return n == 0 ? 0 : std::size_t(engine() % n); }
    void change(std::string& bytes, const std::vector<std::string>& inputs);
    void set_bits(std::string& bytes);
    void set_field(std::string& bytes);
    void set_number(std::string& text);
    void move_piece(std::string& bytes, const std::vector<std::string>& inputs);
    void change_line(std::string& text);

    std::mt19937_64 engine;
};

}  // namespace knead
