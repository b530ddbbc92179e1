/* math_coefficients.h: written by tools/math_coefficients.py, not by hand. */
#ifndef TALUS_MATH_COEFFICIENTS_H
#define TALUS_MATH_COEFFICIENTS_H

/* pi/2 in 36 + 53 bits: k times the first is exact for k < 2^17 */
#define TL_PI_2_NEAR_0 0x1.921fb54440000p+0
#define TL_PI_2_NEAR_1 0x1.68c234c4c6629p-39

/* pi/2 in 22 + 22 + 22 + 53 bits: products exact for k < 2^31 */
#define TL_PI_2_FAR_0 0x1.921fb80000000p+0
#define TL_PI_2_FAR_1 -0x1.5dde980000000p-23
#define TL_PI_2_FAR_2 0x1.8469880000000p-48
#define TL_PI_2_FAR_3 0x1.8cc51701b839ap-72

/* ln 2 in 40 + 53 bits */
#define TL_LN2_0 0x1.62e42fefa4000p-1
#define TL_LN2_1 -0x1.8432a1b0e2634p-43

/* pi/4 in 53 + 53 bits */
#define TL_PI_4_0 0x1.921fb54442d18p-1
#define TL_PI_4_1 0x1.1a62633145c07p-55

/* 3 pi/4 in 53 + 53 bits */
#define TL_PI_3_4_0 0x1.2d97c7f3321d2p+1
#define TL_PI_3_4_1 0x1.a79394c9e8a0ap-54

/* sin x = x + x z P(z), z = x^2, |x| <= pi/4; relative error 3.6e-18 before rounding */
#define TL_SIN_0 -0x1.5555555555548p-3
#define TL_SIN_1 0x1.111111110f7cdp-7
#define TL_SIN_2 -0x1.a01a019bfd854p-13
#define TL_SIN_3 0x1.71de356774aedp-19
#define TL_SIN_4 -0x1.ae5e5a45345b0p-26
#define TL_SIN_5 0x1.5d8fbaeb2f8bfp-33

/* cos x = 1 - z/2 + z^2 P(z), z = x^2, |x| <= pi/4; relative error 5.6e-20 before rounding */
#define TL_COS_0 0x1.555555555554bp-5
#define TL_COS_1 -0x1.6c16c16c14f8ep-10
#define TL_COS_2 0x1.a01a019c83f29p-16
#define TL_COS_3 -0x1.27e4f7ea7fe48p-22
#define TL_COS_4 0x1.1ee9d784e639ep-29
#define TL_COS_5 -0x1.8fa4809568918p-37

/* atan x = x + x z P(z), z = x^2, |x| <= 1/2; relative error 2.1e-19 before rounding */
#define TL_ATAN_0 -0x1.5555555555552p-2
#define TL_ATAN_1 0x1.9999999999021p-3
#define TL_ATAN_2 -0x1.249249245006fp-3
#define TL_ATAN_3 0x1.c71c71a9dfcafp-4
#define TL_ATAN_4 -0x1.745d13753cf3ap-4
#define TL_ATAN_5 0x1.3b135f0f00450p-4
#define TL_ATAN_6 -0x1.110c5f693144ep-4
#define TL_ATAN_7 0x1.e181cd57746e6p-5
#define TL_ATAN_8 -0x1.ac6d49f1e1528p-5
#define TL_ATAN_9 0x1.77e91bcd097ffp-5
#define TL_ATAN_10 -0x1.2ff1a761c2687p-5
#define TL_ATAN_11 0x1.83345d5410c7cp-6
#define TL_ATAN_12 -0x1.11b270456eaf1p-7

/* asin x = x + x z P(z), z = x^2, |x| <= 1/2; relative error 9.5e-19 before rounding */
#define TL_ASIN_0 0x1.5555555555577p-3
#define TL_ASIN_1 0x1.333333332e0ffp-4
#define TL_ASIN_2 0x1.6db6db72143dap-5
#define TL_ASIN_3 0x1.f1c71a945fa1cp-6
#define TL_ASIN_4 0x1.6e8bdeee49a33p-6
#define TL_ASIN_5 0x1.1c49ef7d52584p-6
#define TL_ASIN_6 0x1.ca1fa050d4920p-7
#define TL_ASIN_7 0x1.7584fc9727c46p-7
#define TL_ASIN_8 0x1.613f65bcc419cp-7
#define TL_ASIN_9 0x1.e5cd852ed78dap-9
#define TL_ASIN_10 0x1.63a7d46c468fbp-6
#define TL_ASIN_11 -0x1.580ca245fb5fep-6
#define TL_ASIN_12 0x1.0b4b36e17a0fep-5

/* e^x = 1 + x + x^2 P(x), |x| <= ln(2)/2; relative error 3.8e-18 before rounding */
#define TL_EXP_0 0x1.0000000000009p-1
#define TL_EXP_1 0x1.55555555554fcp-3
#define TL_EXP_2 0x1.5555555550b7fp-5
#define TL_EXP_3 0x1.11111111278d6p-7
#define TL_EXP_4 0x1.6c16c1839fa3dp-10
#define TL_EXP_5 0x1.a01a012a602dap-13
#define TL_EXP_6 0x1.a0199b4e94dcdp-16
#define TL_EXP_7 0x1.71df26dbb9ce6p-19
#define TL_EXP_8 0x1.28ac6c26abeccp-22
#define TL_EXP_9 0x1.ad7b156f42db6p-26

/* ln((1 + s)/(1 - s)) = 2 s + s z P(z), z = s^2, |s| <= tan(pi/8)^2; relative error 1.2e-18 before rounding */
#define TL_LOG_0 0x1.5555555555592p-1
#define TL_LOG_1 0x1.999999997feacp-2
#define TL_LOG_2 0x1.24924941e4699p-2
#define TL_LOG_3 0x1.c71c52131d8f7p-3
#define TL_LOG_4 0x1.74663d055aebdp-3
#define TL_LOG_5 0x1.39a1e8a95b2c8p-3
#define TL_LOG_6 0x1.2f03ae87ab6dep-3

/* tanh x = x + x z P(z), z = x^2, |x| <= 0.55; relative error 5.8e-19 before rounding */
#define TL_TANH_0 -0x1.555555555554fp-2
#define TL_TANH_1 0x1.111111111079fp-3
#define TL_TANH_2 -0x1.ba1ba1b97d88bp-5
#define TL_TANH_3 0x1.664f4859709cep-6
#define TL_TANH_4 -0x1.226e2f147a668p-7
#define TL_TANH_5 0x1.d6d29b96df397p-9
#define TL_TANH_6 -0x1.7d8fd3adc72e7p-10
#define TL_TANH_7 0x1.3483ae98a13f3p-11
#define TL_TANH_8 -0x1.e96fc66d10af5p-13
#define TL_TANH_9 0x1.5d745c55d40e5p-14
#define TL_TANH_10 -0x1.4711113aebc43p-16

#endif
