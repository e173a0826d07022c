#include "host/files/three_mf.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/text_number.h"
#include "host/files/zip.h"

namespace knead {
namespace {

constexpr std::size_t most_model_bytes = std::size_t(1) << 30;
constexpr std::size_t most_placed = 50'000'000;  // vertices and triangles, at all their places
constexpr int deepest_component = 32;

struct XmlTag {
    std::string_view name;                                                  // without its prefix
    bool opens = false, closes = false;                                     // both: empty
    std::size_t at = 0;                                                     // byte
    std::vector<std::pair<std::string_view, std::string_view>> attributes;  // without prefixes

    std::optional<std::string_view> find(std::string_view key) const
    {
        for (const auto& [name_of, value] : attributes)
            if (name_of == key) return value;
        return {};
    }
};

std::string_view local_name(std::string_view name)
{
    const std::size_t colon = name.find(':');
    return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

// The tags of an XML text in order. Text between them, comments and instructions are skipped;
// document types, and with them entities of their own, are refused.
class XmlTags {
  public:
    XmlTags(std::string_view of, std::string where)
        : text(of), path(std::move(where)), at(text_begin(of, path))
    {
    }

    bool next(XmlTag& tag)
    {
        for (;;) {
            at = text.find('<', at);
            if (at == std::string_view::npos) return false;
            if (text.substr(at, 4) == "<!--") {
                skip_to("-->");
            } else if (text.substr(at, 2) == "<?") {
                skip_to("?>");
            } else if (text.substr(at, 9) == "<![CDATA[") {
                skip_to("]]>");
            } else if (text.substr(at, 2) == "<!") {
                fail(at, "no document type", "one");
            } else {
                break;
            }
        }
        read(tag);
        return true;
    }
    [[noreturn]] void fail(std::size_t byte, const std::string& expected,
                           std::string_view found) const
    {
        throw InputError(fmt::format("{}: byte {}: expected {}, found {}", path, byte, expected,
                                     found.substr(0, 60)));
    }

  private:
    static constexpr std::string_view blank = " \t\r\n";
    void skip_to(std::string_view end)
    {
        const std::size_t found = text.find(end, at);
        if (found == std::string_view::npos) fail(at, fmt::format("\"{}\"", end), "the end");
        at = found + end.size();
    }
    void skip_blank() { at = std::min(text.find_first_not_of(blank, at), text.size()); }
    std::string_view word()
    {
        const std::size_t from = at;
        at = std::min(text.find_first_of(" \t\r\n=/><\"'", at), text.size());
        return text.substr(from, at - from);
    }
    void read(XmlTag& tag)
    {
        tag = {};
        tag.at = at++;
        tag.opens = text.substr(at, 1) != "/";
        if (!tag.opens) ++at, tag.closes = true;
        tag.name = local_name(word());
        if (tag.name.empty()) fail(tag.at, "the name of an element", "none");
        for (;;) {
            skip_blank();
            if (at >= text.size()) fail(tag.at, "an element that ends", "the end");
            if (text[at] == '>') return void(++at);
            if (text[at] == '/') {
                tag.closes = true, ++at;
                continue;
            }
            const std::string_view key = word();
            skip_blank();
            if (key.empty() || text.substr(at, 1) != "=") fail(at, "an attribute", "another text");
            ++at, skip_blank();
            const char quote = at < text.size() ? text[at] : '\0';
            const std::size_t end =
                quote == '"' || quote == '\'' ? text.find(quote, at + 1) : std::string_view::npos;
            if (end == std::string_view::npos) fail(at, "a value in quotes", "another text");
            tag.attributes.emplace_back(local_name(key), text.substr(at + 1, end - at - 1));
            at = end + 1;
        }
    }

    std::string_view text;
    std::string path;
    std::size_t at;
};

// x' = x X + y Y + z Z + by
struct PartPlace {
    Vec3<double> x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, by{};
    Vec3<double> turned(Vec3<double> v) const { return v.x * x + v.y * y + v.z * z; }
};
PartPlace within(const PartPlace& outer, const PartPlace& inner)
{
    return {outer.turned(inner.x), outer.turned(inner.y), outer.turned(inner.z),
            outer.turned(inner.by) + outer.by};
}

struct PrintComponent {
    std::string part, id;
    PartPlace place;
    std::size_t at;
};
struct PrintObject {
    FileMesh mesh;
    std::vector<PrintComponent> components;
};
struct PrintPart {
    std::map<std::string, PrintObject, std::less<>> objects;
    std::map<std::string, std::vector<Vec3<float>>, std::less<>> colours;  // by the group's id
    std::vector<PrintComponent> items;
    double unit = 0.001;
};

class ThreeMf {
  public:
    ThreeMf(const std::string& bytes, const std::string& from) : zip(bytes, from), path(from) {}

    MeshFile read()
    {
        const std::string start = start_part();
        const PrintPart& model = part(start);
        if (model.items.empty())
            throw InputError(path + ": " + start +
                             ": expected an item of its "
                             "build, found none");
        for (const PrintComponent& item : model.items) place(item, start, {}, 0);
        if (file.meshes.empty()) throw InputError(path + ": expected triangles, found none");
        for (FileMesh& mesh : file.meshes) {
            for (Vec3<double>& v : mesh.vertices) v = model.unit * v;
            check_mesh(mesh, path);
        }
        file.unit = model.unit;
        return std::move(file);
    }

  private:
    static std::string without_slash(std::string_view name)
    {
        return std::string(name.starts_with('/') ? name.substr(1) : name);
    }

    std::string start_part()
    {
        const std::string relations = "_rels/.rels";
        if (zip.has(relations)) {
            const std::string text = zip.read(relations, max_json_bytes);
            XmlTags tags(text, path + ": " + relations);
            for (XmlTag tag; tags.next(tag);)
                if (const auto type = tag.find("Type");
                    tag.name == "Relationship" && type && type->ends_with("/3dmodel"))
                    if (const auto target = tag.find("Target")) return without_slash(*target);
        }
        return "3D/3dmodel.model";
    }

    const PrintPart& part(const std::string& name)
    {
        if (const auto known = parts.find(name); known != parts.end()) return known->second;
        PrintPart& made = parts[name];
        parse(name, made);
        return made;
    }

    struct At {
        const XmlTags& tags;
        const XmlTag& tag;
        [[noreturn]] void fail(const std::string& expected, std::string_view found) const
        {
            tags.fail(tag.at, expected, found);
        }
        std::string_view text(const char* key) const
        {
            const auto found = tag.find(key);
            if (!found) fail(fmt::format("the attribute \"{}\" of <{}>", key, tag.name), "none");
            return *found;
        }
        double number(std::string_view word, const char* key) const
        {
            const TextNumber found = finite_text_number(word);
            if (!found.fault.empty())
                fail(fmt::format("a finite number for \"{}\"", key),
                     fmt::format("\"{}\"{}", word.substr(0, 40), in_brackets(found.fault)));
            return found.value;
        }
        double number(const char* key) const { return number(text(key), key); }
        int index(const char* key) const
        {
            const double n = number(key);
            if (!(n >= 0 && n < std::numeric_limits<int>::max() && n == std::floor(n)))
                fail(fmt::format("a whole number for \"{}\"", key), short_number(n));
            return int(n);
        }
        PartPlace transform() const
        {
            const auto given = tag.find("transform");
            if (!given) return {};
            std::array<double, 12> m;
            std::size_t at = 0, count = 0;
            for (; count < m.size(); ++count) {
                at = std::min(given->find_first_not_of(" \t\r\n", at), given->size());
                const std::size_t end =
                    std::min(given->find_first_of(" \t\r\n", at), given->size());
                if (at == end) break;
                m[count] = number(given->substr(at, end - at), "transform"), at = end;
            }
            if (count < m.size()) fail("12 numbers of a transform", std::to_string(count));
            return {
                {m[0], m[1], m[2]}, {m[3], m[4], m[5]}, {m[6], m[7], m[8]}, {m[9], m[10], m[11]}};
        }
        // "#RRGGBB" or "#RRGGBBAA"
        Vec3<float> colour(const char* key) const
        {
            const std::string_view c = text(key);
            unsigned rgb = 0;
            const bool good =
                (c.size() == 7 || c.size() == 9) && c[0] == '#' &&
                std::from_chars(c.data() + 1, c.data() + 7, rgb, 16).ptr == c.data() + 7;
            if (!good) fail("a colour, #RRGGBB", c);
            return linear_colour(
                {(rgb >> 16) / 255.0, (rgb >> 8 & 255) / 255.0, (rgb & 255) / 255.0});
        }
    };

    static void take_model(const At& at, PrintPart& to)
    {
        constexpr std::pair<std::string_view, double> units[] = {
            {"micron", 1e-6}, {"millimeter", 1e-3}, {"centimeter", 1e-2},
            {"inch", 0.0254}, {"foot", 0.3048},     {"meter", 1}};
        if (const auto unit = at.tag.find("unit")) {
            const auto known =
                std::ranges::find(units, *unit, &std::pair<std::string_view, double>::first);
            if (known == std::end(units)) at.fail("a unit of lengths", *unit);
            to.unit = known->second;
        }
        std::vector<std::string_view> required;
        const std::string_view given = at.tag.find("requiredextensions").value_or("");
        for (std::size_t from = 0; from < given.size();) {
            from = std::min(given.find_first_not_of(' ', from), given.size());
            const std::size_t end = std::min(given.find(' ', from), given.size());
            const std::string_view name = given.substr(from, end - from);
            if (!name.empty() && name != "p" && name != "m")
                at.fail("no extension that is not known here (p and m are)", name);
            from = end;
        }
    }

    void parse(const std::string& name, PrintPart& to)
    {
        const std::string text = zip.read(name, most_model_bytes);
        XmlTags tags(text, path + ": " + name);
        PrintObject* object = nullptr;
        std::vector<Vec3<float>>* group = nullptr;
        // Of the object, and of the triangles that name no group.
        std::string of_object;
        std::optional<int> number_in_group;
        for (XmlTag tag; tags.next(tag);) {
            const At at{tags, tag};
            if (!tag.opens) {
                if (tag.name == "object") object = nullptr;
                continue;
            }
            if (tag.name == "model") {
                take_model(at, to);
            } else if (tag.name == "basematerials" || tag.name == "colorgroup") {
                group = &to.colours[std::string(at.text("id"))];
            } else if (tag.name == "base" && group) {
                group->push_back(tag.find("displaycolor") ? at.colour("displaycolor")
                                                          : Vec3<float>{1, 1, 1});
            } else if (tag.name == "color" && group) {
                group->push_back(at.colour("color"));
            } else if (tag.name == "object") {
                object = &to.objects[std::string(at.text("id"))];
                object->mesh.name = std::string(tag.find("name").value_or(""));
                of_object = std::string(tag.find("pid").value_or(""));
                number_in_group.reset();
                if (tag.find("pindex")) number_in_group = at.index("pindex");
            } else if (tag.name == "vertex" && object) {
                object->mesh.vertices.push_back({at.number("x"), at.number("y"), at.number("z")});
            } else if (tag.name == "triangle" && object) {
                const Int3 t{at.index("v1"), at.index("v2"), at.index("v3")};
                object->mesh.triangles.push_back(t);
                paint(at, to, object->mesh, t, of_object, number_in_group);
            } else if (tag.name == "component" && object) {
                object->components.push_back(component(at));
            } else if (tag.name == "item") {
                to.items.push_back(component(at));
            }
        }
        for (auto& [id, one] : to.objects)
            if (!one.mesh.colours.empty())
                one.mesh.colours.resize(one.mesh.vertices.size(), {1, 1, 1});
    }

    static PrintComponent component(const At& at)
    {
        const auto other = at.tag.find("path");
        return {other ? without_slash(*other) : "", std::string(at.text("objectid")),
                at.transform(), at.tag.at};
    }

    static void paint(const At& at, const PrintPart& in, FileMesh& mesh, Int3 t,
                      const std::string& of_object, std::optional<int> number)
    {
        const auto group = in.colours.find(at.tag.find("pid").value_or(of_object));
        if (group == in.colours.end()) return;
        const int corner[3] = {t.x, t.y, t.z};
        constexpr const char* corner_keys[3] = {"p1", "p2", "p3"};
        for (int k = 0; k < 3; ++k) {
            const char* key = at.tag.find(corner_keys[k]) ? corner_keys[k] : "p1";
            const int colour = at.tag.find(key) ? at.index(key) : number.value_or(-1);
            if (colour < 0) return;
            if (std::size_t(colour) >= group->second.size())
                at.fail(fmt::format("one of {} colours", group->second.size()),
                        std::to_string(colour));
            const auto vertex = std::size_t(corner[k]);
            if (vertex >= mesh.vertices.size()) return;  // refused when all are known
            if (mesh.colours.size() <= vertex) mesh.colours.resize(vertex + 1, {1, 1, 1});
            mesh.colours[vertex] = group->second[std::size_t(colour)];
        }
    }

    void place(const PrintComponent& item, const std::string& in, const PartPlace& outer, int depth)
    {
        const std::string& name = item.part.empty() ? in : item.part;
        const PrintPart& model = part(name);
        const auto found = model.objects.find(item.id);
        const auto fail = [&](const std::string& expected, const std::string& other) {
            throw InputError(fmt::format("{}: {}: byte {}: expected {}, found {}", path, in,
                                         item.at, expected, other));
        };
        if (found == model.objects.end())
            fail("an object of " + name, "\"" + item.id.substr(0, 40) + "\"");
        if (depth > deepest_component)
            fail(fmt::format("at most {} objects in each other", deepest_component), "more");
        const PrintObject& object = found->second;
        const PartPlace here = within(outer, item.place);
        placed += object.mesh.vertices.size() + object.mesh.triangles.size() + 1;
        if (placed > most_placed)
            fail(fmt::format("at most {} vertices and triangles", most_placed), "more");
        if (!object.mesh.triangles.empty()) {
            FileMesh mesh = object.mesh;
            for (Vec3<double>& v : mesh.vertices) v = here.turned(v) + here.by;
            if (dot(here.x, cross(here.y, here.z)) < 0)
                for (Int3& t : mesh.triangles) std::swap(t.y, t.z);
            file.meshes.push_back(std::move(mesh));
        }
        for (const PrintComponent& one : object.components) place(one, name, here, depth + 1);
    }

    const ZipReader zip;
    const std::string& path;
    std::map<std::string, PrintPart> parts;
    std::size_t placed = 0;
    MeshFile file;
};

std::string escaped_xml(const std::string& text)
{
    std::string out;
    for (const char c : text) switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '"':
                out += "&quot;";
                break;
            default:
                out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
        }
    return out;
}

unsigned srgb_bytes(Vec3<float> c)
{
    const auto byte = [](float s) {
        s = std::clamp(s, 0.0f, 1.0f);
        const float shown = s <= 0.0031308f ? 12.92f * s : 1.055f * std::pow(s, 1 / 2.4f) - 0.055f;
        return unsigned(std::lround(255 * shown));
    };
    return byte(c.x) << 16 | byte(c.y) << 8 | byte(c.z);
}

void add_number(std::string& text, float value)
{
    char digits[32];
    text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

// Colours first, then the object that names them.
void add_print_object(std::string& text, const Mesh& mesh, const std::string& name, std::size_t i)
{
    std::vector<unsigned> palette, of_vertex;
    for (const Vec3<float> c : mesh.colours) of_vertex.push_back(srgb_bytes(c));
    palette = of_vertex;
    if (palette.empty()) palette = {srgb_bytes(category_colour(mesh.category))};
    std::ranges::sort(palette);
    palette.erase(std::ranges::unique(palette).begin(), palette.end());
    const std::size_t group = 2 * i + 1, object = group + 1;
    text += fmt::format("<m:colorgroup id=\"{}\">", group);
    for (const unsigned rgb : palette) text += fmt::format("<m:color color=\"#{:06X}\"/>", rgb);
    text += "</m:colorgroup>\n";
    text +=
        fmt::format("<object id=\"{}\" type=\"model\" name=\"{}\" pid=\"{}\" pindex=\"0\"><mesh>",
                    object, escaped_xml(name), group);
    text += "<vertices>\n";
    for (const Vec3<float> v : mesh.vertices) {
        text += "<vertex x=\"", add_number(text, v.x);
        text += "\" y=\"", add_number(text, v.y);
        text += "\" z=\"", add_number(text, v.z), text += "\"/>\n";
    }
    text += "</vertices><triangles>\n";
    const auto colour = [&](int v) {
        return std::ranges::lower_bound(palette, of_vertex[std::size_t(v)]) - palette.begin();
    };
    for (const Int3 t : mesh.triangles) {
        text += fmt::format("<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"", t.x, t.y, t.z);
        if (!of_vertex.empty())
            text += fmt::format(" pid=\"{}\" p1=\"{}\" p2=\"{}\" p3=\"{}\"", group, colour(t.x),
                                colour(t.y), colour(t.z));
        text += "/>\n";
    }
    text += "</triangles></mesh></object>\n";
}

}  // namespace

MeshFile parse_3mf(const std::string& bytes, const std::string& path)
{
    return ThreeMf(bytes, path).read();
}

std::string three_mf_bytes(const std::vector<const Mesh*>& meshes,
                           const std::vector<std::string>& names, const std::string& unit,
                           const std::string& path)
{
    const std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
    const char* const known = unit == "millimetres"   ? "millimeter"
                              : unit == "centimetres" ? "centimeter"
                              : unit == "inches"      ? "inch"
                                                      : "meter";
    std::string model =
        xml + fmt::format(
                  "<model unit=\"{}\" xml:lang=\"en-US\" "
                  "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
                  "xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\">\n"
                  "<metadata name=\"Application\">knead</metadata>\n<resources>\n",
                  known);
    for (std::size_t i = 0; i < meshes.size(); ++i)
        add_print_object(model, *meshes[i], names[i], i);
    model += "</resources>\n<build>\n";
    for (std::size_t i = 0; i < meshes.size(); ++i)
        model += fmt::format("<item objectid=\"{}\"/>\n", 2 * i + 2);
    model += "</build>\n</model>\n";
    const std::string types =
        xml +
        "<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">"
        "<Default Extension=\"rels\" "
        "ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>"
        "<Default Extension=\"model\" "
        "ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/></Types>\n";
    const std::string relations =
        xml +
        "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">"
        "<Relationship Target=\"/3D/3dmodel.model\" Id=\"rel0\" "
        "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>\n";
    return zip_bytes({{"[Content_Types].xml", types},
                      {"_rels/.rels", relations},
                      {"3D/3dmodel.model", std::move(model)}},
                     path);
}

}  // namespace knead
