// Steps of a running scene by either codec: what undo and redo put into the simulator.
#include "host/session/scene_history.h"

#include <gtest/gtest.h>

#include "host/base/json_reader.h"
#include "host/hands/motion.h"
#include "host/scene/scene_hands.h"
#include "tests/session/clay_rows.h"

namespace knead {
namespace {

// A shipped scene with its history. Steps begin by commands.
class ScenePast {
  public:
    explicit ScenePast(Codec codec)
        : scene(pinch()),
          hands(hands_of(scene), scene.hands),
          solver(cpu_solver(scene.setup)),
          splats(scene, {}),
          loop(*solver, recorded_motion(&hands, scene.hands), loop_options(scene)),
          editor({scene, splats, loop, solver.get(), [](const HandsOptions&) {}, {}},
                 std::make_shared<const Document>(document_of(scene)), ids),
          history(
              {scene,
               splats,
               loop,
               solver.get(),
               editor,
               past,
               {},
               [this](const HistoryStep&, const FutureCapture& made) { captures.push_back(made); },
               codec},
              "Open")
    {
    }
    void change(double gravity)
    {
        apply(SetGravity{{0, -gravity, 0}});
        for (int i = 0; i < 5; ++i) {
            ASSERT_TRUE(loop.step());
            editor.after_frame(loop.last());
            history.after_frame(loop.last());
        }
        history.close();
        past.resident();
        past.evict();
    }
    void apply(const Command& command)
    {
        EXPECT_FALSE(history.apply({command, 0, Origin::script, 0}).refusal);
    }
    ClayRows rows() const { return solver->rows(*solver->snapshot()); }

    Scene scene;
    HandSource hands;
    std::unique_ptr<EditableSimulator> solver;
    SceneSplats splats;
    SessionLoop loop;
    IdSource ids;
    SceneEditor editor;
    History past;
    std::vector<FutureCapture> captures;
    SceneHistory history;

  private:
    static Scene pinch()
    {
        const char* const file = "scenes/pinch.json";
        Scene scene = parse_scene(read_text(file, 1 << 20), file, {"domain.cells=24"});
        build(scene, std::size_t(1) << 30);
        return scene;
    }
};

TEST(SceneHistory, UndoAndRedoReturnToTheRowsOfTheStepsByEitherCodec)
{
    for (const Codec codec : {Codec::automatic, Codec::lossless, Codec::quantised}) {
        ScenePast scene(codec);
        const Quantisation steps = quantisation_of(scene.solver->config());
        std::vector<ClayRows> states{scene.rows()};
        for (const double gravity : {20.0, 30.0, 40.0}) {
            scene.change(gravity);
            const ClayRows now = scene.rows();
            states.push_back(codec == Codec::quantised ? quantised(now, steps) : now);
        }
        ASSERT_EQ(scene.captures.size(), 3u);
        for (const FutureCapture& made : scene.captures) {
            const std::string& bytes = made.get().edge->from_parent;
            EXPECT_EQ(bytes.substr(0, 6), codec == Codec::quantised ? "step.2" : "step.1");
        }
        for (const int to : {2, 1, 0, 1, 2, 3, 2, 3}) {
            if (to < int(scene.past.current().id))
                scene.apply(Undo{});
            else
                scene.apply(Redo{});
            EXPECT_EQ(scene.past.current().id, StepId(to));
            EXPECT_TRUE(same_rows(scene.rows(), states[std::size_t(to)])) << to;
        }
    }
}

TEST(SceneHistory, GoToTheCurrentStepTakesBackWhatTheClayDidByItselfAndUndoOfANameDoesNot)
{
    ScenePast scene(Codec::lossless);
    scene.change(20);
    const ClayRows of_step = scene.rows();
    const auto step = int(scene.past.current().id);
    const auto moves = [&] {
        ASSERT_TRUE(scene.loop.step());
        scene.history.after_frame(scene.loop.last());
        ASSERT_FALSE(same_rows(scene.rows(), of_step));
    };
    moves();
    scene.apply(GoTo{step});
    EXPECT_TRUE(same_rows(scene.rows(), of_step));
    EXPECT_EQ(scene.past.current().id, StepId(step));

    moves();
    const ClayRows moved = scene.rows();
    scene.apply(Rename{ObjectId{1}, "other"});
    scene.apply(Undo{});
    EXPECT_EQ(scene.past.current().id, StepId(step));
    EXPECT_NE(scene.editor.document()->objects.at(0)->name, "other");
    EXPECT_TRUE(same_rows(scene.rows(), moved));
}

}  // namespace
}  // namespace knead
