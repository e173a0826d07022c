// The verbs of the command line and their options; parsing is in main.cpp. Every verb returns an
// exit code of host/base/errors.h, or throws one of its errors.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "host/scene/new_scene.h"

namespace knead {

struct RunOptions {
    std::string scene;
    std::string device = "auto";
    std::vector<std::string> settings;  // path.key=value
    std::string hands;                  // a recording or gesture instead of the scene's
    int frames = 0;                     // 0: the scene's
    std::string out;                    // folder; "": no files
    bool overwrite = false, deterministic = false, json = false, quiet = false, verbose = false;
    std::optional<unsigned> seed;
    int threads = 0;           // 0: all
    double max_memory = 0;     // [MiB]; 0: free memory
    double time_limit = 0;     // [s]; 0: none
    int audit_every = 0;       // frames; 0: every frame on the CPU, one in 10 on a GPU
    std::string mesh = "glb";  // glb, ply, obj, stl, none
    int cells = 0;             // along the longest axis of the domain; 0: the scene's
    int mesh_every = 0;        // frames between meshes of a sequence; 0: none
    int particles_every = 0;   // frames between particle files of a sequence; 0: none
    int pictures = -1;         // frames between pictures; 0: none; -1: the scene's
    bool video = false, particles = false;
    // ply, compressed.ply, splat, spz, sog, glb, none; only for scenes with splats
    std::string splats = "ply";
    std::optional<double> checkpoint;  // interval [s]; 0: none
    std::string resume;                // folder of an interrupted run to resume
    std::string commands;              // log of commands; "": none
    bool keep_going = false;           // commands that are refused do not end the run
};
int run_verb(const RunOptions& options);

struct RecordOptions {
    std::string gesture, out;  // out: .hands or .jsonl
    double rate = 60, seconds = 0, jitter = 0, dropouts = 0, latency = 0.038, radius = 0.1,
           depth = 0;
    unsigned seed = 1;
    bool live = false;  // only explains how knead vr records
    bool overwrite = false, quiet = false;
};
int record_verb(const RecordOptions& options);

struct VrOptions {
    std::string scene = new_scene_name;
    std::string device = "auto";
    std::vector<std::string> settings;   // path.key=value
    int cells = 0;                       // along the longest axis of the domain; 0: the scene's
    int frames = 0;                      // 0: until the user leaves
    std::string out;                     // folder; "": no files
    std::string record;                  // .hands or .jsonl; "": none
    std::string binding = "auto";        // auto, egl, glx, wgl
    std::string place = "0,-0.35,-0.5";  // position of the clay relative to the user [m]
    double rate = 0;         // requested display refresh rate [1/s]; 0: the runtime's default
    double patience = 20;    // time limit for recovering a lost runtime [s]
    int samples = 0;         // samples per pixel; 0: chosen by device
    double eye_scale = 0.5;  // smallest fraction of an eye's sides that is drawn
    double foveate = 0;      // [degrees] drawn at full resolution; 0: all
    int threads = 0;         // 0: all
    bool standing = false, see_through = false, recorded = false, no_panel = false;
    bool hands_only = false;  // records hands, simulates nothing
    bool no_sound = false;
    bool deterministic = false, overwrite = false, json = false, quiet = false;
};
int vr_verb(const VrOptions& options);

struct InfoOptions {
    std::string file;
    std::vector<std::string> settings;
    int cells = 0;  // of a scene, along the longest axis of its domain; 0: the scene's
    bool json = false;
};
int info_verb(const InfoOptions& options);

struct CompareOptions {
    std::string first, second;
    double tolerance = 1e-6;  // relative for reports; metres for particles
    double slower = 0;        // allowed ratio of the median frame times, second to first; 0: any
    bool json = false;
};
int compare_verb(const CompareOptions& options);

struct ConvertOptions {
    std::string in, out;  // "-": standard input, standard output
    bool overwrite = false, quiet = false;
    std::string from = "", to = "";  // formats of standard input and output, e.g. "obj"
    int spz_version = 3;             // of splats written as .spz, 2 to 4
    double scale = 1;                // of meshes
    std::string unit = "";           // of a mesh that is written: m, cm, mm, in; "": m, 3MF mm
};
int convert_verb(const ConvertOptions& options);

struct RenderOptions {
    std::vector<std::string> files;  // splat files; or the folder of a run with pictures
    std::string out, video;          // .png; .mp4 and others; at least one of both
    std::string path;                // file of camera keys; "": none
    double rate = 30;                // frames per second of the video
    std::string device = "auto";
    std::string size = "1280x960";
    std::string eye, at;     // "x,y,z" [m]; "": chosen to show most splats
    std::string up = "-y";   // the axis that points upwards
    std::string background;  // "r,g,b", 0 to 1; "": black
    double field = 50;       // horizontal field of view [degrees]
    double foveate = 0;      // [degrees] around the centre drawn at full resolution; 0: all
    int orbit = 0;           // number of pictures of one orbit; 0: a single picture
    bool stereo = false, overwrite = false, quiet = false;
};
int render_verb(const RenderOptions& options);

struct ViewOptions {
    std::string scene = new_scene_name;
    std::string device = "auto";
    std::vector<std::string> settings;
    int cells = 0;                      // along the longest axis of the domain; 0: the scene's
    std::string size = "1280x800";      // of the window
    int frames = 0;                     // frames drawn; 0: until the window is closed
    std::string screenshot;             // of the last frame
    std::string script;                 // file of mouse and key events; uses simulated time
    std::string out;                    // folder; "": no files
    std::string record;                 // .hands or .jsonl; "": none
    bool paused = false, bare = false;  // starts paused; hides the panels
    double max_memory = 0;              // [MiB]; 0: free memory
    bool overwrite = false, quiet = false;
};
int view_verb(const ViewOptions& options);

struct ReplayVerbOptions {
    std::string file;                     // a session
    std::string device = "auto";          // auto: that of the session
    std::string to;                       // number of a step; "": to the end
    std::string record, mesh, particles;  // files to write; "": none
    int threads = 0;                      // CPU; 0: all
    bool check = false, json = false, overwrite = false, quiet = false;
};
int replay_verb(const ReplayVerbOptions& options);

struct SessionVerbOptions {
    std::string action;  // list, verify, compact
    std::string file, out;
    bool json = false, overwrite = false, quiet = false;
};
int session_verb(const SessionVerbOptions& options);

struct DoctorOptions {
    std::vector<std::string> folders{"."};  // folders searched for leftover files
    bool json = false;
};
int doctor_verb(const DoctorOptions& options);

struct ListOptions {
    std::string kind;  // presets, materials (the same), gestures, scenes
};
int list_verb(const ListOptions& options);

struct NewOptions {
    std::string out;  // .json; "-": standard output
    bool overwrite = false, quiet = false;
};
int new_verb(const NewOptions& options);

struct VerifyOptions;  // host/verify/verify.h
int verify_verb(VerifyOptions options);

}  // namespace knead
