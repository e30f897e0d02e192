// Passes time with Pinocchio's articulated-body algorithm: a row of joints with springs, and an explicit Runge-Kutta
// method whose tableau the generated header `tableaus.h` holds. Everything is allocated before the loop.
#include <pinocchio/algorithm/aba.hpp>

#include "tableaus.h"

namespace
{
namespace pin = pinocchio;
using Vector = Eigen::VectorXd;

// The joints that cranes need: choosing among few is faster than among all of Pinocchio's, and compiles in half the
// time. Its algorithms ask for the last two by name.
template <typename S, int O> struct Joints {
    typedef S Scalar;
    static constexpr int Options = O;
    typedef pin::JointModelCompositeTpl<S, O, Joints> JointModelComposite;
    typedef pin::JointDataCompositeTpl<S, O, Joints> JointDataComposite;
    typedef pin::JointModelMimicTpl<S, O, Joints> JointModelMimic;
    typedef pin::JointDataMimicTpl<S, O, Joints> JointDataMimic;
    typedef boost::variant<pin::JointModelRevoluteTpl<S, O, 0>, pin::JointModelRevoluteTpl<S, O, 1>,
                           pin::JointModelRevoluteTpl<S, O, 2>, pin::JointModelPrismaticTpl<S, O, 0>,
                           pin::JointModelPrismaticTpl<S, O, 2>, boost::recursive_wrapper<JointModelMimic>>
        JointModelVariant;
    typedef boost::variant<pin::JointDataRevoluteTpl<S, O, 0>, pin::JointDataRevoluteTpl<S, O, 1>,
                           pin::JointDataRevoluteTpl<S, O, 2>, pin::JointDataPrismaticTpl<S, O, 0>,
                           pin::JointDataPrismaticTpl<S, O, 2>, boost::recursive_wrapper<JointDataMimic>>
        JointDataVariant;
};
using Model = pin::ModelTpl<double, 0, Joints>;
using Data = pin::DataTpl<double, 0, Joints>;
using JointModel = pin::JointModelTpl<double, 0, Joints>;

struct Joint { // as `pinocchio_engine.pack_joints` lays it out
    double slides, axis, offset[3], mass, centre[3], inertia[3], stiffness, rest;
};

JointModel model_of(const Joint &joint)
{
    const int axis = int(joint.axis);
    if (joint.slides != 0.0)
        return axis == 0 ? JointModel(pin::JointModelPX()) : JointModel(pin::JointModelPZ());
    return axis == 0   ? JointModel(pin::JointModelRX())
           : axis == 1 ? JointModel(pin::JointModelRY())
                       : JointModel(pin::JointModelRZ());
}

Model build(const Joint *joints, int n, double gravity)
{
    Model model;
    model.gravity.linear() << 0.0, 0.0, -gravity;
    for (int i = 0; i < n; i++) {
        const Joint &joint = joints[i];
        const pin::SE3 place(Eigen::Matrix3d::Identity(), Eigen::Map<const Eigen::Vector3d>(joint.offset));
        const Eigen::Matrix3d turning = Eigen::Map<const Eigen::Vector3d>(joint.inertia).asDiagonal();
        const auto id = model.addJoint(i, model_of(joint), place, std::to_string(i));
        const pin::Inertia body(joint.mass, Eigen::Map<const Eigen::Vector3d>(joint.centre), turning);
        model.appendBodyToJoint(id, body, pin::SE3::Identity());
    }
    return model;
}

struct Crane {
    Model model;
    Data data;
    Vector stiffness, rest, effort;

    Crane(const Joint *joints, int n, double gravity)
        : model(build(joints, n, gravity)), data(model), stiffness(n), rest(n), effort(n)
    {
        for (int i = 0; i < n; i++)
            stiffness[i] = joints[i].stiffness, rest[i] = joints[i].rest;
    }

    template <class In, class Out> void derivative(const In &x, Out &&out)
    {
        const auto n = model.nv;
        effort = stiffness.cwiseProduct(rest - x.head(n));
        out.head(n) = x.tail(n);
        out.tail(n) = pin::aba(model, data, x.head(n), x.tail(n), effort, pin::Convention::WORLD);
    }
};

template <class Tableau> void pass(Crane &crane, Vector &x, double h, long steps)
{
    constexpr int stages = Tableau::stages;
    Eigen::MatrixXd k(x.size(), stages);
    Vector y(x.size());
    for (long step = 0; step < steps; step++) {
        crane.derivative(x, k.col(0));
#pragma GCC unroll 16
        for (int i = 1; i < stages; i++) {
            y = x;
#pragma GCC unroll 16
            for (int j = 0; j < i; j++)
                if (Tableau::a[i][j] != 0.0)
                    y += (h * Tableau::a[i][j]) * k.col(j);
            crane.derivative(y, k.col(i));
        }
#pragma GCC unroll 16
        for (int i = 0; i < stages; i++)
            if (Tableau::b[i] != 0.0)
                x += (h * Tableau::b[i]) * k.col(i);
    }
}
} // namespace

extern "C" {
Crane *crane_new(const Joint *joints, int n, double gravity) { return new Crane(joints, n, gravity); }

void crane_delete(Crane *crane) { delete crane; }

// Takes `steps` steps of size h from rest at q0 and writes the final joints to q, `times` times over.
void crane_pass(Crane *crane, int order, const double *q0, double h, long steps, long times, double *q)
{
    const int n = crane->model.nv;
    Vector x(2 * n);
    for (long time = 0; time < times; time++) {
        x << Eigen::Map<const Vector>(q0, n), Vector::Zero(n);
        if (order == 4)
            pass<Order4>(*crane, x, h, steps);
        else
            pass<Order8>(*crane, x, h, steps);
    }
    Eigen::Map<Vector>(q, n) = x.head(n);
    if (!x.allFinite())
        crane->data = Data(crane->model); // what is no number would stay in it
}
}
