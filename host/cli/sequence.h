// Files of a run with rising numbers, which Blender, Houdini and others take for one moving thing.
#pragma once
#include <functional>
#include <string>

namespace knead {

class Sequence {
  public:
    // FOLDER/STEM_0001.ENDING and on, for every frame whose number `every` divides; 0: none.
    Sequence(std::string folder, std::string stem, std::string ending, int every);

    bool wanted() const { return every > 0; }
    int count() const { return written; }
    const std::string& place() const { return folder; }
    // Removes what an earlier run left: files of exactly such names, of any ending that a mesh has.
    // Throws OutputError.
    void remove_old() const;
    // Removes what is left of files that were not written to their end.
    void remove_partial() const;
    // Writes the file of a frame. Throws OutputError where the disk refuses; after that, nothing.
    void add(int frame, const std::function<void(const std::string& file)>& write);

  private:
    std::string folder, stem, ending;
    int every, written = 0;
    bool refused = false;
};

}  // namespace knead
