#include "render/draw_timer.h"

namespace knead {

DrawTimer::DrawTimer() { glCreateQueries(GL_TIME_ELAPSED, GLsizei(most), queries.data()); }
DrawTimer::~DrawTimer() { glDeleteQueries(GLsizei(most), queries.data()); }

void DrawTimer::begin(float scale)
{
    if (timing) end();  // end() was skipped: drawing threw
    timing = begun - read < most;
    if (!timing) return;
    scales[begun % most] = scale;
    glBeginQuery(GL_TIME_ELAPSED, queries[begun % most]);
}

void DrawTimer::end()
{
    if (!timing) return;
    glEndQuery(GL_TIME_ELAPSED);
    ++begun;
    timing = false;
}

std::optional<DrawTimer::Reading> DrawTimer::poll()
{
    if (read == begun) return {};
    const GLuint query = queries[read % most];
    GLint known = 0;
    glGetQueryObjectiv(query, GL_QUERY_RESULT_AVAILABLE, &known);
    if (!known) return {};
    GLuint64 nanoseconds = 0;
    glGetQueryObjectui64v(query, GL_QUERY_RESULT, &nanoseconds);
    return Reading{1e-9 * double(nanoseconds), scales[read++ % most]};
}

}  // namespace knead
