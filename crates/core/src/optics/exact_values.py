"""Weights of segments with linear extinction to 50 digits, rounded to 25.

Made exact_values.csv once: python3 exact_values.py exact_values.csv (mpmath 1.3).
Up to optical depth 1 a series of 60 terms, above it the closed form in 120
digits; every row must fulfill front + back = alpha to 45 digits, and a random
part is compared with quadrature of the definition.
"""
import random
import sys

from mpmath import mp, mpf, exp, expm1, erfc, erfi, sqrt, pi, quad
def series(a,b):
    m=(a+b)/2; d=(b-a)/2
    M=m/2; D=d/2
    u=mpf(0); q=mpf(0); s=mpf(0)
    for i in range(60,-1,-1):
        u=D/(2*i+3)*(1+u)
        f=M*M/((2*i+2)*(2*i+3))
        q=(2*i-u)+f*q; s=1+f*s
    s*=M
    return exp(-M)*(s+q), exp(-M)*(s-q)
def closed(a,b):
    m=(a+b)/2; e=exp(-m)
    if a==b: psi=-expm1(-m)/m
    else:
        r=sqrt(2*abs(b-a)); x=a/r; y=b/r
        def big(x): return x>mpf(10)**8
        if b>a:
            f=lambda x: sum((-1)**k*mp.fac2(2*k-1)/(2*x*x)**k for k in range(12))/(x*sqrt(pi)) if big(x) else exp(x*x)*erfc(x)
            psi=sqrt(pi)/r*(f(x)-e*f(y))
        else:
            f=lambda x: sum(mp.fac2(2*k-1)/(2*x*x)**k for k in range(12))/(2*x) if big(x) else sqrt(pi)/2*exp(-x*x)*erfi(x)
            psi=2/r*(f(x)-e*f(y))
    return 1-psi, psi-e
def direct(a,b):
    T=lambda s: exp(-(a*s+(b-a)*s*s/2))
    n=max(1,int(a+b)); pts=[mpf(i)/n for i in range(n+1)]
    return (quad(lambda s:(1-s)*(a+(b-a)*s)*T(s),pts),quad(lambda s:s*(a+(b-a)*s)*T(s),pts))
def weights(a,b):
    mp.dps=60
    a,b=mpf(a),mpf(b)
    if (a+b)/2<=1: return series(a,b)
    mp.dps=120
    return closed(a,b)
if __name__=="__main__":
    random.seed(2)
    ms=[1e-320,1e-310,1e-300,1e-200,1e-100,1e-30,1e-16,1e-10,1e-8,1e-5,1e-3,1/32,0.0313,0.1,0.25,0.5,0.999999,1.0,1.000001,1.5,2,5,10,30,88,100,700,745,1e3,1e4,1e6,1e10,1e30,1e100,1e300,8e307]
    rs=[0.0,1e-12,1e-6,0.1,0.5,1-1e-3,1-1e-5,1-1e-7,1-1e-10,1-1e-14,1.0]
    rows=set()
    for m in ms:
        for r in rs:
            b=2*m/(1+r); a=b*r
            rows|={(a,b),(b,a)}
    for _ in range(150):
        m=10**random.uniform(-8,4); r=random.choice([random.random(),10**random.uniform(-12,0),1-10**random.uniform(-14,0)])
        b=2*m/(1+r); a=b*r
        rows|={(a,b),(b,a)}
    out=open(sys.argv[1],"w")
    out.write("a,b,front,back,alpha\n")
    worst=0
    for a,b in sorted(rows):
        f,k=weights(a,b)
        mp.dps=60
        al=-expm1(-(mpf(a)+mpf(b))/2)
        if (1e-3<a+b<30 and random.random()<0.15):
            F,K=direct(mpf(a),mpf(b)); worst=max(worst,abs(F/f-1),abs(K/k-1))
        worst2=abs((f+k)/al-1) if al else 0
        assert worst2<mpf(10)**-45,(a,b,worst2)
        n=lambda x: mp.nstr(x,25)
        out.write("%r,%r,%s,%s,%s\n"%(a,b,n(f),n(k),n(al)))
    print(len(rows), "worst against quadrature", mp.nstr(worst,3))
