// Captures and owns CUDA graphs.
#pragma once
#include "cuda/device/launch.cuh"

namespace knead::gpu {

struct Stream {
    cudaStream_t s = nullptr;
    Stream() { check(cudaStreamCreateWithFlags(&s, cudaStreamNonBlocking), "stream"); }
    Stream(const Stream&) = delete;
    ~Stream() { cudaStreamDestroy(s); }
    operator cudaStream_t() const { return s; }
};

struct Event {
    cudaEvent_t e = nullptr;
    explicit Event(unsigned flags = cudaEventDefault)
    {
        check(cudaEventCreateWithFlags(&e, flags), "event");
    }
    Event(const Event&) = delete;
    ~Event() { cudaEventDestroy(e); }
    operator cudaEvent_t() const { return e; }
};

struct Graph {
    cudaGraph_t graph = nullptr;
    cudaGraphExec_t ready = nullptr;
    Graph() = default;
    Graph(const Graph&) = delete;
    ~Graph() { drop(); }
    // Captures the launches on the stream between begin and end. Meanwhile no thread of the process
    // may call cudaDeviceSynchronize: that would end the capture.
    void begin(cudaStream_t stream)
    {
        drop();
        check(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal), "capture");
    }
    void end(cudaStream_t stream)
    {
        check(cudaStreamEndCapture(stream, &graph), "capture");
        check(cudaGraphInstantiate(&ready, graph, 0), "graph");
    }
    void drop()
    {
        if (ready) cudaGraphExecDestroy(ready);
        if (graph) cudaGraphDestroy(graph);
        ready = nullptr, graph = nullptr;
    }
};

// Adds a conditional node to the captured graph: its body runs once or not at all, or repeatedly,
// as decided on the device. Returns the body.
inline cudaGraph_t add_conditional(cudaStream_t captured, cudaGraphConditionalNodeType type,
                                   cudaGraphConditionalHandle handle)
{
    cudaStreamCaptureStatus status;
    cudaGraph_t graph;
    const cudaGraphNode_t* before;
    std::size_t count;
    cudaGraphNodeParams params{};
    params.type = cudaGraphNodeTypeConditional;
    params.conditional.handle = handle;
    params.conditional.type = type;
    params.conditional.size = 1;
    cudaGraphNode_t node;
#if CUDART_VERSION >= 13000
    check(cudaStreamGetCaptureInfo(captured, &status, nullptr, &graph, &before, nullptr, &count),
          "capture");
    check(cudaGraphAddNode(&node, graph, before, nullptr, count, &params), "conditional node");
    check(cudaStreamUpdateCaptureDependencies(captured, &node, nullptr, 1,
                                              cudaStreamSetCaptureDependencies),
          "capture");
#else
    check(cudaStreamGetCaptureInfo_v2(captured, &status, nullptr, &graph, &before, &count),
          "capture");
    check(cudaGraphAddNode(&node, graph, before, count, &params), "conditional node");
    check(cudaStreamUpdateCaptureDependencies(captured, &node, 1, cudaStreamSetCaptureDependencies),
          "capture");
#endif
    return params.conditional.phGraph_out[0];
}

// The graph that the stream is being captured into.
inline cudaGraph_t under_capture(cudaStream_t captured)
{
    cudaStreamCaptureStatus state;
    cudaGraph_t graph;
#if CUDART_VERSION >= 13000
    check(cudaStreamGetCaptureInfo(captured, &state, nullptr, &graph, nullptr, nullptr, nullptr),
          "capture");
#else
    check(cudaStreamGetCaptureInfo_v2(captured, &state, nullptr, &graph, nullptr, nullptr),
          "capture");
#endif
    return graph;
}

// Captures what `record(body)` launches on the stream `body` as the body of a conditional node.
template <class Record>
void capture_body(cudaGraph_t into, cudaStream_t body, Record&& record)
{
    check(cudaStreamBeginCaptureToGraph(body, into, nullptr, nullptr, 0,
                                        cudaStreamCaptureModeThreadLocal),
          "capture");
    record(body);
    cudaGraph_t same;
    check(cudaStreamEndCapture(body, &same), "capture");
}

}  // namespace knead::gpu
