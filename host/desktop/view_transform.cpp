// Moving, turning and scaling of objects in the window of `knead view`.
#include <algorithm>
#include <utility>

#include "host/desktop/view_app.h"
#include "host/picture/outline.h"
#include "host/ui/panel_commands.h"
#include "host/ui/session_line.h"

namespace knead {

TransformView ViewApp::transform_view() const
{
    const int covered = drawing ? drawing->covered() : 0;
    return {cast<double>(camera.eye()), cast<double>(camera.forward()),
            cast<double>(camera.ray(float(input.x()), float(input.y()), window->width(),
                                    window->height(), covered))};
}

// The command that a gesture would send says first why it cannot be.
void ViewApp::begin_transform(TransformKind kind)
{
    const std::vector<ObjectId> chosen = selection(panel.ui);
    if (nozzle) return;  // clay is being laid
    if (panel.ui.mouse_hand) return panel.note("The mouse leads a hand: H lets go of it.");
    if (chosen.empty()) return panel.note("No object is chosen: click on one.");
    if (const std::string why = why_not_moved(*state, panel.ui.document, chosen); !why.empty())
        return panel.note(why);
    watch.find(session, window_time);
    const auto& places = watch.places;
    const CommonPlace common = common_place(*places, chosen);
    if (!common.any()) return panel.note("The chosen object has no clay.");
    gesture.emplace(kind, chosen, common.centre, transform_view());
    std::vector<Vec3<float>> some;
    for (const ObjectId id : chosen)
        if (const ObjectPlace* const one = places->find(id))
            some.insert(some.end(), one->some.begin(), one->some.end());
    gesture->set_clay(std::move(some), common.spacing);
    preview = object_previews(*meshes_of(*state), *state->document, *places, chosen,
                              0.003 * camera.distance());
    below.reset(), hovered = {};
    pressing = false;
}

// The clay of other objects below the pointer, as it was when the gesture began; else the floor.
std::optional<TransformSurface> ViewApp::surface_at(const TransformView& view) const
{
    if (const auto hit = pick_surface(preview.others, view.eye, view.ray))
        return TransformSurface{hit->point, hit->normal};
    return floor_at(view);
}

std::optional<TransformSurface> ViewApp::floor_at(const TransformView& view) const
{
    const WallOptions& walls = shown->scene.setup.walls;
    if (!(view.ray.y < 0)) return {};
    const Vec3<double> point = view.eye + ((walls.min.y - view.eye.y) / view.ray.y) * view.ray;
    const bool inside = point.x >= walls.min.x && point.x <= walls.max.x &&
                        point.z >= walls.min.z && point.z <= walls.max.z;
    if (!inside) return {};
    return TransformSurface{{point.x, walls.min.y, point.z}, {0, 1, 0}};
}

// All keys and buttons are the gesture's while there is one.
void ViewApp::take_transform()
{
    for (const int c : input.typed()) gesture->type(c);
    if (input.went_down(key_backspace)) gesture->erase();
    for (int axis = 0; axis < 3; ++axis)
        if (input.went_down('X' + axis)) gesture->choose_axis(axis, input.shift());
    const bool flips = input.control() && input.shift();
    const TransformView view = transform_view();
    std::optional<TransformSurface> surface;
    if (gesture->kind() == TransformKind::move && panel.ui.on_surface != flips)
        surface = surface_at(view);
    gesture->point(view, input.control() && !input.shift(), surface);
    if (input.pressed({key_escape}) || input.clicked(button_right)) return end_transform(false);
    if (input.went_down(key_enter) || input.went_down(key_keypad_enter) ||
        input.clicked(button_left))
        return end_transform(true);
    constexpr std::pair<int, TransformKind> others[] = {
        {'G', TransformKind::move}, {'R', TransformKind::turn}, {'S', TransformKind::scale}};
    for (const auto& [key, kind] : others)
        if (input.pressed({key}) && kind != gesture->kind()) {
            end_transform(false);
            return begin_transform(kind);
        }
}

void ViewApp::end_transform(bool applies)
{
    std::optional<Command> command;
    if (applies && state->scene) command = gesture->command(state->scene->scene.origin);
    gesture.reset();
    preview = {};
    buttons_ignored = true;
    if (!command) return;
    if (const std::string why = why_not(*command, *state); !why.empty()) return panel.note(why);
    panel.send(std::move(*command), session);
}

// Puts down the object that is added on what is below the pointer.
void ViewApp::take_placing()
{
    const TransformView view = transform_view();
    const auto clay = pick(*state, view.eye, view.ray);
    std::optional<TransformSurface> on;
    if (clay) on = TransformSurface{clay->point, clay->normal};
    if (!on) on = floor_at(view);
    placing_at.reset();
    // Half a cell above the clay, whose surface is around its particles.
    if (on && state->scene)
        placing_at = resting_on(*panel.ui.placing, *on, shown->scene.setup.lattice.dx / 2);
    if (input.clicked(button_right)) {
        panel.ui.placing.reset(), panel.ui.notice.clear();
        buttons_ignored = true;
    } else if (input.clicked(button_left)) {
        buttons_ignored = true;
        if (!placing_at) return panel.note("There is neither clay nor floor below the pointer.");
        panel.send(AddObject{placed(*panel.ui.placing, *placing_at, state->scene->scene.origin)},
                   session);
        panel.ui.placing.reset(), panel.ui.notice.clear();
    }
    if (!panel.ui.placing) placing_at.reset();
}

std::vector<HandLook> ViewApp::placing_looks() const
{
    return {mark_look(object_outline(*panel.ui.placing, *placing_at, 0.003 * camera.distance()),
                      chosen_colour)};
}

// Lays clay on what is below the pointer, from the button's press to its release.
void ViewApp::take_nozzle(bool begins, bool held)
{
    const TransformView view = transform_view();
    if (begins && !nozzle && state->scene && panel.ui.document) {
        const auto clay = pick(*state, view.eye, view.ray);
        std::optional<TransformSurface> on;
        if (clay) on = TransformSurface{clay->point, clay->normal};
        if (!on) on = floor_at(view);
        if (!on) return panel.note("There is neither clay nor floor below the pointer.");
        NozzleGesture next(nozzle_tool(panel.ui), view, *on, state->scene->scene.origin);
        if (const std::string why = why_not(next.begin(), *state); !why.empty())
            return panel.note(why);
        nozzle = std::move(next);
        panel.send(nozzle->begin(), session);
    }
    if (!nozzle || !held) return;
    if (clogged(*state, *nozzle)) panel.note(clogged_notice);
    if (auto moves = nozzle->move(view)) panel.send(std::move(*moves), session);
}

void ViewApp::end_nozzle(bool keeps)
{
    panel.send(nozzle->end(), session);
    nozzle.reset();
    if (!keeps) panel.apply({{Control::undo, 0}, {}, 0}, session);
}

// What the gesture would do to the objects, and its axes.
std::vector<HandLook> ViewApp::transform_looks() const
{
    constexpr Vec3<float> axis_colours[] = {
        {0.8f, 0.03f, 0.05f}, {0.1f, 0.5f, 0.03f}, {0.03f, 0.15f, 0.8f}};
    std::vector<HandLook> looks;
    const auto at = [&](Vec3<double> x, Vec3<double> own) { return gesture->at(x, own); };
    for (const ObjectPreview& one : preview.objects)
        looks.push_back(preview_look(one, at, gesture->turn()));
    const double reach = 4 * camera.distance(), thick = 0.002 * camera.distance();
    for (const Vec3<double>& axis : gesture->axes()) {
        Mesh line;
        const Vec3<double> from =
            gesture->plane() ? gesture->centre() + gesture->by() : gesture->centre();
        add_line(line, from - reach * axis, from + reach * axis, thick);
        looks.push_back(mark_look(std::move(line), axis.x > 0   ? axis_colours[0]
                                                   : axis.y > 0 ? axis_colours[1]
                                                                : axis_colours[2]));
    }
    return looks;
}

}  // namespace knead
