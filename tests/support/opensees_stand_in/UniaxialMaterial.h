// What a uniaxial material of OpenSees overrides, by the names and signatures that its elements call. Written for the
// tests: no line of OpenSees is in it, and nothing of it computes.
#pragma once

class Channel;
class FEM_ObjectBroker;
class OPS_Stream;

class UniaxialMaterial {
  public:
    UniaxialMaterial(int tag, int /* class tag */) : tag(tag) {}
    virtual ~UniaxialMaterial() = default;
    virtual int setTrialStrain(double strain, double strainRate = 0.0) = 0;
    virtual double getStrain() = 0;
    virtual double getStrainRate() { return 0.0; }
    virtual double getStress() = 0;
    virtual double getTangent() = 0;
    virtual double getInitialTangent() = 0;
    virtual double getDampTangent() { return 0.0; }
    virtual int commitState() = 0;
    virtual int revertToLastCommit() = 0;
    virtual int revertToStart() = 0;
    virtual UniaxialMaterial *getCopy() = 0;
    virtual int sendSelf(int commitTag, Channel &channel) = 0;
    virtual int recvSelf(int commitTag, Channel &channel, FEM_ObjectBroker &broker) = 0;
    virtual void Print(OPS_Stream &stream, int flag = 0) = 0;

  private:
    int tag;
};
