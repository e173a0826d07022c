// Numbered files of a run, which Blender, Houdini and others read as one animation.
#pragma once
#include <functional>
#include <string>

namespace knead {

class Sequence {
  public:
    // FOLDER/STEM_0001.ENDING and so on, one file every `every` frames; 0: none.
    Sequence(std::string folder, std::string stem, std::string ending, int every);

    bool wanted() const { return every > 0; }
    int count() const { return written; }
    const std::string& place() const { return folder; }
    // Removes the files of an earlier run: exactly such names, with any mesh extension. Throws
    // OutputError.
    void remove_old() const;
    // Removes partially written files.
    void remove_partial() const;
    // Writes the file of a frame, if one is due. Throws OutputError on a write error; later calls
    // do nothing.
    void add(int frame, const std::function<void(const std::string& file)>& write);

  private:
    std::string folder, stem, ending;
    int every, written = 0;
    bool refused = false;
};

}  // namespace knead
