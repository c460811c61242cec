within ;
package StribeckArm "The paper's experiment around the FMU of a two-link arm"

  package Interfaces "What the experiment needs of an arm"
    partial model Arm "Torques in, positions and velocities out"
      parameter Integer n = 2 "Joints";
      Modelica.Blocks.Interfaces.RealInput tau[n](each unit = "N.m") "Commanded torques";
      Modelica.Blocks.Interfaces.RealOutput q[n](each unit = "rad") "Positions";
      Modelica.Blocks.Interfaces.RealOutput dq[n](each unit = "rad/s") "Velocities";
    end Arm;
  end Interfaces;

  function tustin "Friction torque of eq. (1): C0 + C1 exp(-|v|/alpha) + C2 |v|, with the sign of the velocity"
    input Real v(unit = "rad/s") "Velocity";
    input Real c0(unit = "N.m");
    input Real c1(unit = "N.m");
    input Real c2(unit = "N.m.s/rad");
    input Real alpha(unit = "rad/s");
    output Real torque(unit = "N.m");
  algorithm
    torque := sign(v) * (c0 + c1 * exp(-abs(v) / alpha) + c2 * abs(v));
  end tustin;

  block Controller "Sampled PD with friction compensation from the reference velocity, eqs. (13) and (14)"
    parameter Real Ts(unit = "s") = 0.0125 "Sample time";
    parameter Real kp(unit = "N.m/rad") = 30 "Position gain";
    parameter Real kv(unit = "N.m.s/rad") = 2 * sqrt(kp) "Velocity gain; give 2 sqrt(kp J) for critical damping";
    parameter Real rate(unit = "rad/s") = 0.05 "Reference velocity";
    parameter Real ratio = 0.9 "Compensation over true friction";
    parameter Real c0(unit = "N.m") = 5 "Coulomb friction";
    parameter Real c1(unit = "N.m") = 1.25 "Break-away above Coulomb friction";
    parameter Real c2(unit = "N.m.s/rad") = 1.5 "Viscous friction";
    parameter Real alpha(unit = "rad/s") = 0.05 "Speed of the decay";
    Modelica.Blocks.Interfaces.RealInput q(unit = "rad") "Measured position";
    Modelica.Blocks.Interfaces.RealOutput tau(unit = "N.m") "Torque, held between samples";
    discrete Real reference(unit = "rad", start = 0, fixed = true);
    discrete Real measured(unit = "rad", start = 0, fixed = true);
    discrete Real velocity(unit = "rad/s", start = 0, fixed = true) "Backward difference of the position";
    discrete Real command(unit = "N.m", start = 0, fixed = true);
  equation
    when sample(0, Ts) then
      reference = rate * time;
      measured = q;
      velocity = if time > 0.5 * Ts then (measured - pre(measured)) / Ts else 0;
      command = kp * (reference - measured) + kv * (rate - velocity)
        + ratio * tustin(rate, c0, c1, c2, alpha);
    end when;
    tau = command;
  end Controller;

  package Examples
    model PaperExperiment "Joint A on a slow ramp with compensation, joint B held; section 4.3.2 of the paper"
      replaceable model ImportedArm = StribeckArm.Interfaces.Arm constrainedby StribeckArm.Interfaces.Arm
        "The wrapped FMU";
      parameter Real jointInertia[2](each unit = "kg.m2") = {0.8082, 0.134}
        "Inertia at each joint with the other held, from the arm file, in the pose q = 0";
      ImportedArm arm(n = 2) "The arm";
      Controller a(kp = 30, kv = 2 * sqrt(30 * jointInertia[1]), rate = 0.05, ratio = 0.9) "Joint A";
      Controller b(kp = 60, kv = 2 * sqrt(60 * jointInertia[2]), rate = 0, ratio = 0) "Joint B";
    equation
      connect(arm.q[1], a.q);
      connect(arm.q[2], b.q);
      connect(a.tau, arm.tau[1]);
      connect(b.tau, arm.tau[2]);
      annotation (
        experiment(StartTime = 0, StopTime = 5, Interval = 0.0125, Tolerance = 1e-9),
        Documentation(info = "<html>
<p>1. Export the arm (<code>stribeck export-fmu fmu/two_link_nominal/arm.toml --out two_link.fmu</code>) and import the
file: OpenModelica, File, Import, FMU; Dymola, File, Open, Import FMU. The tool makes a model; OpenModelica calls it
<code>two_link_arm_me_FMU</code>.</p>
<p>2. Wrap it, with the name of the model and of its connectors as the tool has them. OpenModelica, which puts an
underscore for each bracket:</p>
<pre>
model Imported
  extends StribeckArm.Interfaces.Arm(n = 2);
  two_link_arm_me_FMU fmu;
equation
  fmu.tau_1_ = tau[1];
  fmu.tau_2_ = tau[2];
  q = {fmu.q_1_, fmu.q_2_};
  dq = {fmu.dq_1_, fmu.dq_2_};
end Imported;
</pre>
<p>3. Simulate <code>PaperExperiment(redeclare model ImportedArm = Imported)</code> and compare <code>arm.q[1]</code> with
column <code>q1</code> of <code>fmu/two_link_nominal/loop_reference.csv</code>.</p>
</html>"));
    end PaperExperiment;
  end Examples;

  annotation (
    version = "1",
    uses(Modelica(version = "4.0.0")));
end StribeckArm;
