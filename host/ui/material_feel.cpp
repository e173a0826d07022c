#include "host/ui/material_feel.h"

#include <iterator>
#include <limits>

namespace knead {
namespace {

struct Word {
    double below;
    const char* text;
};
constexpr double any = std::numeric_limits<double>::infinity();

const char* word_of(double value, const Word* words)
{
    while (!(value < words->below) && words->below < any) ++words;
    return words->text;
}

// By Young's modulus [Pa].
constexpr Word stiffness[] = {{2e4, "soft as jelly"}, {1.5e5, "very soft"}, {6e5, "soft"},
                              {2e6, "firm"},          {6e6, "stiff"},       {any, "hard"}};
// By yield stress [Pa].
constexpr Word yields[] = {{2e3, "keeps a touch"},
                           {1.5e4, "keeps a light press"},
                           {6e4, "keeps a firm press"},
                           {3e5, "keeps a strong press"},
                           {any, "hardly keeps a press"}};
// By viscosity [Pa s].
constexpr Word flows[] = {{1, "runs like oil"}, {100, "runs like honey"}, {any, "creeps like tar"}};
// By cohesion [Pa].
constexpr Word grains[] = {{100, "runs through the fingers"}, {any, "crumbles"}};

}  // namespace

std::string feel_of(const MaterialSpec& m)
{
    const std::string first = word_of(m.young, stiffness);
    switch (m.plasticity) {
        case Plasticity::fluid:
            return word_of(m.viscosity, flows);
        case Plasticity::herschel_bulkley:
            return first + ", sags slowly, " + word_of(m.yield, yields);
        case Plasticity::drucker_prager:
            return word_of(m.cohesion, grains);
        case Plasticity::clamp:
            return first + ", packs and breaks";
        case Plasticity::von_mises:
            return first + ", " + word_of(m.yield, yields);
        case Plasticity::none:
            break;
    }
    return first + ", springs back";
}

}  // namespace knead
