// Bodies fall, bounce and roll without Unity: `mono fall.exe scene.carom` prints what was heard, as JSON.
using System;
using System.IO;

static class Fall
{
    const int Rate = 60, Bodies = 200, Seconds = 4;
    const float Gravity = 9.81f, Radius = 0.04f;

    static int Main(string[] words)
    {
        using (var scene = new Carom.Scene(File.ReadAllBytes(words[0])))
        {
            var chance = new Random(1);
            var height = new float[Bodies];
            var fall = new float[Bodies];
            var along = new float[Bodies];
            var number = new int[Bodies];
            int ground = scene.Body("ground"), frames = (int)(scene.Rate / Rate);
            float peak = 0f;
            scene.Govern(0.15);
            scene.Listen(new[] { 0f, 1.5f, -2f }, new[] { 1f, 0f, 0f });
            for (int n = 0; n < Bodies; n++)
            {
                scene.Send("/object/new ball." + n + " ball size " + (0.6 + 0.01 * (n % 80)).ToString("R", System.Globalization.CultureInfo.InvariantCulture));
                number[n] = scene.Body("ball." + n);
                height[n] = 0.2f + 2f * (float)chance.NextDouble();
            }
            var sound = new float[frames * scene.Channels];
            for (int frame = 0; frame < Rate * Seconds; frame++)
            {
                for (int n = 0; n < Bodies; n++)
                {
                    fall[n] -= Gravity / Rate;
                    height[n] += fall[n] / Rate;
                    along[n] += 0.5f / Rate;
                    float[] at = { along[n], height[n], 0.1f * n };
                    if (height[n] < Radius)
                    {
                        height[n] = Radius;
                        scene.Touch(ground, number[n], new[] { at[0], 0f, at[2] }, new[] { 0f, 1f, 0f }, speed: -fall[n]);
                        fall[n] = fall[n] < -0.4f ? -0.5f * fall[n] : 0f;
                    }
                    if (frame > Rate * Seconds - 30 && n % 2 == 0) continue; // it sleeps
                    scene.Move(number[n], at, new[] { 1f, 0f, 0f, 0f }, new[] { 0.5f, fall[n], 0f }, new[] { 0f, 0f, -0.5f / Radius });
                }
                scene.Frame(1.0 / Rate);
                scene.Process(sound, frames);
                foreach (float each in sound) peak = Math.Max(peak, Math.Abs(each));
            }
            Carom.Contacts told = scene.Report();
            Console.WriteLine("{{\"blows\": {0}, \"slides\": {1}, \"bodies\": {2}, \"peak\": {3}}}", (long)told.Blows,
                (long)told.Slides, (long)told.Bodies, peak.ToString("R", System.Globalization.CultureInfo.InvariantCulture));
        }
        return 0;
    }
}
