#include "host/cli/camera_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/base/json_reader.h"

namespace knead {
namespace {

using V = Vec3<double>;

CameraKey read_key(const Json& value, const std::string& file, std::size_t at)
{
    CameraKey key{};
    ObjectReader::read(value, file, fmt::format("/keys/{}", at), [&](ObjectReader& r) {
        key.time = r.number("time", {0, 3600, "s"});
        key.view.eye = r.vector("eye", {-1e6, 1e6, "m"});
        key.view.at = r.vector("at", {-1e6, 1e6, "m"});
        if (!(length(key.view.eye - key.view.at) > 1e-9))
            r.fail("eye", "another place than \"at\"", "the same");
    });
    return key;
}

// Velocity at a key: difference of its neighbours over their time.
V rate(const std::vector<CameraKey>& keys, std::size_t k, V View::*place)
{
    const CameraKey &before = keys[k > 0 ? k - 1 : k],
                    &behind = keys[std::min(k + 1, keys.size() - 1)];
    return (1 / (behind.time - before.time)) * (behind.view.*place - before.view.*place);
}

// Cubic Hermite interpolation with these positions and rates at both ends of `span` [s], at t in
// [0, 1].
V cubic(V from, V from_rate, V to, V to_rate, double span, double t)
{
    const double u = 1 - t;
    return (u * u * (1 + 2 * t)) * from + (t * t * (1 + 2 * u)) * to +
           (span * t * u) * (u * from_rate - t * to_rate);
}

}  // namespace

std::vector<CameraKey> read_camera_path(const std::string& file)
{
    std::vector<CameraKey> keys;
    ObjectReader::read(read_json(file), file, "", [&](ObjectReader& r) {
        const std::string expected = "knead.path/1", found = r.text("schema", "");
        if (found != expected) r.fail("schema", '"' + expected + '"', '"' + found + '"');
        const Json& all = r.required("keys", "an array of at least 2 keys");
        if (!all.is_array() || all.size() < 2)
            r.fail("keys", "an array of at least 2 keys", described(all));
        for (const Json& value : all) {
            keys.push_back(read_key(value, file, keys.size()));
            const std::size_t k = keys.size() - 1;
            if (k > 0 && !(keys[k].time > keys[k - 1].time + 1e-6))
                r.fail("keys", "times that rise",
                       fmt::format("{} s after {} s", keys[k].time, keys[k - 1].time));
        }
    });
    return keys;
}

View view_at(const std::vector<CameraKey>& keys, double time)
{
    if (time <= keys.front().time) return keys.front().view;
    if (time >= keys.back().time) return keys.back().view;
    std::size_t k = 0;
    while (keys[k + 1].time <= time) ++k;
    const double span = keys[k + 1].time - keys[k].time, t = (time - keys[k].time) / span;
    const auto between = [&](V View::*place) {
        return cubic(keys[k].view.*place, rate(keys, k, place), keys[k + 1].view.*place,
                     rate(keys, k + 1, place), span, t);
    };
    return {between(&View::eye), between(&View::at)};
}

}  // namespace knead
