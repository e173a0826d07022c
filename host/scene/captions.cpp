#include "host/scene/captions.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace knead {

std::vector<Caption> read_captions(ObjectReader& pictures)
{
    std::vector<Caption> captions;
    const Json* const all = pictures.find("captions");
    if (!all) return captions;
    if (!all->is_array() || all->size() > 256)
        pictures.fail("captions", "an array of at most 256 captions", described(*all));
    for (const Json& one : *all) {
        const std::string at = fmt::format("{}/{}", pictures.pointer("captions"), captions.size());
        ObjectReader::read(one, pictures.file(), at, [&](ObjectReader& r) {
            Caption caption{r.text("text", ""), r.vector("at", {-1000, 1000, "m"})};
            const auto printable = [](char c) { return c >= ' ' && c <= '~'; };
            if (caption.text.empty() || caption.text.size() > 60 ||
                !std::all_of(caption.text.begin(), caption.text.end(), printable))
                r.fail("text", "1 to 60 printable characters of ASCII",
                       described(Json(caption.text)));
            captions.push_back(caption);
        });
    }
    return captions;
}

}  // namespace knead
