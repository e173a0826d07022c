// knead doctor: what is installed, what is missing, and the consequences.
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/machine.h"
#include "host/base/outputs.h"
#include "host/base/print.h"
#include "host/cli/verbs.h"
#include "host/files/video.h"
#include "host/files/webp.h"
#include "host/scene/seed.h"
#include "host/share/sharing.h"
#include "render/painter.h"
#include "xr/headset.h"
#ifdef KNEAD_HAS_GL
#include "render/context.h"
#endif

namespace knead {
namespace {

using Json = nlohmann::json;

Json finding(const std::string& what, bool there, const std::string& text)
{
    return {{"what", what}, {"there", there}, {"text", text}};
}

// Creates a solver with one particle: reports the device, or why there is none.
Json cuda_finding()
{
    const std::string without = "; everything runs on the CPU";
#ifndef KNEAD_HAS_CUDA
    return finding("CUDA", false, "this build has no CUDA side" + without);
#else
    if (!gpu_present()) return finding("CUDA", false, "no device or no driver" + without);
    try {
        Setup setup{};
        setup.lattice = {{16, 16, 16}, 1.0 / 16};
        setup.walls = walls_inside(setup.lattice, 3, ContactMode::separate, 0);
        Material<double> m = preset("clay");
        m.volume = 1e-6, m.mass = m.density * m.volume;
        setup.materials = {m};
        setup.particles = {{{0.5, 0.5, 0.5}, {}, {}, {}, 0, 0, 0}};
        return finding("CUDA", true, gpu_solver(setup, 0)->name());
    } catch (const std::exception& e) {
        return finding("CUDA", false, e.what() + without);
    }
#endif
}

Json pictures_finding()
{
    try {
        return finding("OpenGL", true, Painter::open()->name());
    } catch (const std::exception& e) {
        return finding("OpenGL", false, std::string(e.what()) + "; runs make no pictures");
    }
}

// Tests sharing in an off-screen context; that of a window or headset may differ.
Json sharing_finding()
{
#ifdef KNEAD_HAS_GL
    try {
        const Context context;
        const Context::Bound bound(context);
        const Sharing found = sharing(0);
        return finding("sharing", found.shared, found.text);
    } catch (const std::exception&) {
        return finding("sharing", false, "no OpenGL to share with");
    }
#else
    return finding("sharing", false, "no OpenGL to share with");
#endif
}

std::string joined(const std::vector<std::string>& words)
{
    return words.empty() ? "none" : fmt::format("{}", fmt::join(words, " "));
}

std::string offer(const RuntimeInfo& facts)
{
    const std::string text = fmt::format("{}; the runtime of {} offers {}", facts.headset,
                                         facts.manifest, joined(facts.used));
    return facts.missing.empty() ? text : text + "; not " + joined(facts.missing);
}

// Requires a responding headset, not only an installed runtime.
Json openxr_finding()
{
    const RuntimeInfo facts = runtime_facts();
    const std::string without = "; no knead vr";
    const std::string named =
        facts.manifest.empty() ? "" : " (the runtime is named by " + facts.manifest + ")";
    Json of = finding("OpenXR", facts.runtime && facts.reason.empty(),
                      facts.reason.empty() ? offer(facts) : facts.reason + named + without);
    of["loader"] = facts.loader, of["runtime"] = facts.manifest, of["headset"] = facts.headset;
    of["extensions"] = facts.used, of["missing"] = facts.missing;
    return of;
}

// Searches the folders and their direct subfolders, where runs write their results.
void add_leftovers(Json& all, const std::vector<std::string>& folders)
{
    namespace fs = std::filesystem;
    for (const std::string& folder : folders) {
        std::error_code problem;
        if (!fs::is_directory(folder, problem)) throw InputError(folder + ": no such folder");
        std::vector<std::string> places{folder};
        for (fs::directory_iterator at(folder, problem), end; !problem && at != end;
             at.increment(problem)) {
            std::error_code unknown;
            if (!fs::is_directory(at->symlink_status(unknown))) continue;
            places.push_back(at->path().string());
            for (const char* below : {"pictures", "meshes", "particles"})  // of a run
                if (fs::is_directory(fs::symlink_status(at->path() / below, unknown)))
                    places.push_back((at->path() / below).string());
        }
        if (problem) throw InputError(folder + ": cannot be read: " + problem.message());
        for (const std::string& place : places) {
            if (fs::directory_iterator(place, problem); problem)
                all.push_back(
                    finding("unread", false, place + ": cannot be read: " + problem.message()));
            for (const Leftover& left : leftovers(place)) {
                const std::string of = left.of == lock_name ? "a lock" : "of " + left.of;
                const std::string text =
                    left.path + ": " + of + ", by a program that was killed; may go";
                all.push_back(finding("leftover", true, text));
            }
        }
    }
}

}  // namespace

int doctor_verb(const DoctorOptions& o)
{
    const bool ffmpeg = Video::available();
    Json all = Json::array();
    all.push_back(finding("knead", true, knead_version() + ", " + compiler_name()));
    all.push_back(finding("CPU", true, fmt::format("{}, {} threads", cpu_name(), cpu_count())));
    all.push_back(
        finding("memory", true,
                fmt::format("{:.1f} GiB, {:.1f} GiB free", double(total_memory()) / 0x1p30,
                            double(available_memory()) / 0x1p30)));
    all.push_back(cuda_finding());
    all.push_back(pictures_finding());
    all.push_back(sharing_finding());
    all.push_back(
        finding("ffmpeg", ffmpeg, ffmpeg ? "on the PATH" : "not on the PATH; no --video"));
    all.push_back(finding("libwebp", webp_available(),
                          webp_available() ? "in this build" : "not in this build; no SOG"));
    all.push_back(openxr_finding());
    add_leftovers(all, o.folders);
    if (o.json) {
        print(all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
        return exit_ok;
    }
    for (const Json& f : all)
        print(fmt::format("{:<8} {:<10} {}\n",
                          f["what"] == "leftover"  ? "left"
                          : f["what"] == "unread"  ? "unread"
                          : f["there"].get<bool>() ? "ok"
                                                   : "missing",
                          f["what"].get<std::string>(), f["text"].get<std::string>()));
    return exit_ok;
}

}  // namespace knead
