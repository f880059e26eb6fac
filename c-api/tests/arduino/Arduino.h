/* What the sketch uses of the Arduino core of the STM32, with its names and types; it is no part of a drive. */
#ifndef ARDUINO_STAND_IN_H
#define ARDUINO_STAND_IN_H

#include <stdint.h>

enum { A0 = 0, A1 = 1, A2 = 2 };
struct TIM_TypeDef;
#define TIM3 ((TIM_TypeDef *)0)
enum TimerFormat_t { HERTZ_FORMAT };

/* The only timer. */
class HardwareTimer {
public:
  explicit constexpr HardwareTimer(TIM_TypeDef *) {}
  void setOverflow(uint32_t value, TimerFormat_t format);
  void attachInterrupt(void (*callback)());
  void resume();
};

class Port {
public:
  void begin(unsigned long baud);
  void print(const char *text);
  void println(const char *text);
};
extern Port Serial;

void analogReadResolution(int bits);
int analogRead(uint32_t pin);
uint32_t millis();

void setup();
void loop();

#endif
