// Bytes that are read where they are asked for: of a string, or of a file through a window that
// moves over it, so that a large file need not fit into memory beside what is made of it.
#pragma once
#include <cstddef>
#include <cstring>
#include <memory>
#include <string>

namespace knead {

// A regular file, open for reading.
class OpenFile {
  public:
    // Throws InputError.
    explicit OpenFile(const std::string& path);
    ~OpenFile();
    OpenFile(const OpenFile&) = delete;
    OpenFile& operator=(const OpenFile&) = delete;

    std::size_t size() const { return bytes; }
    // Throws InputError if fewer are there.
    void read(std::size_t from, std::size_t size, char* to) const;

  private:
    [[noreturn]] void fail(int reason) const;

    std::string path;
    int descriptor = -1;
    std::size_t bytes = 0;
};

// Copies share the file or the string, which must outlive them, but not the window.
class ByteWindow {
  public:
    explicit ByteWindow(const std::string& bytes) : whole(bytes.data()), all(bytes.size()) {}
    explicit ByteWindow(std::shared_ptr<const OpenFile> of) : file(std::move(of)), all(file->size())
    {
    }
    ByteWindow(const ByteWindow& other) : whole(other.whole), file(other.file), all(other.all) {}
    ByteWindow& operator=(const ByteWindow&) = delete;

    std::size_t size() const { return all; }
    // Precondition: inside.
    template <class T>
    T at(std::size_t offset) const
    {
        T value;
        std::memcpy(&value, pointer(offset, sizeof value), sizeof value);
        return value;
    }
    // `count` bytes at `offset`, inside; valid until the next call.
    const char* pointer(std::size_t offset, std::size_t count) const
    {
        if (whole) return whole + offset;
        if (offset < from || offset + count > from + window.size()) move_to(offset, count);
        return window.data() + (offset - from);
    }

  private:
    void move_to(std::size_t offset, std::size_t count) const;

    const char* whole = nullptr;
    std::shared_ptr<const OpenFile> file;
    std::size_t all;
    mutable std::string window;
    mutable std::size_t from = 0;
};

}  // namespace knead
