// A scene that Carom has exported, for C#: the functions of carom.h.
using System;
using System.Runtime.InteropServices;

namespace Carom
{
    [StructLayout(LayoutKind.Sequential)]
    public struct Contacts
    {
        // long of C has 32 bits on Windows, and as many as a pointer elsewhere.
        public CLong Blows, Faint, Slides, LeftOut;
        public double Loudest;
        public CLong Crowded, Bodies;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct CLong
    {
#if UNITY_STANDALONE_WIN || UNITY_EDITOR_WIN
        public int Value;
#else
        public IntPtr Value;
#endif
        public static implicit operator long(CLong of) { return (long)of.Value; }
    }

    public sealed class Scene : IDisposable
    {
        const string Library = "carom"; // libcarom.so, carom.dll, libcarom.dylib
        IntPtr handle;

        [DllImport(Library)] static extern IntPtr carom_open(byte[] baked, UIntPtr size, int live);
        [DllImport(Library)] static extern int carom_send(IntPtr scene, byte[] message, double at);
        [DllImport(Library)] static extern IntPtr carom_answer(IntPtr scene);
        [DllImport(Library)] static extern void carom_process(IntPtr scene, [In, Out] float[] sound, UIntPtr frames);
        [DllImport(Library)] static extern int carom_channels(IntPtr scene);
        [DllImport(Library)] static extern double carom_rate(IntPtr scene);
        [DllImport(Library)] static extern int carom_body(IntPtr scene, byte[] name);
        [DllImport(Library)] static extern int carom_move(IntPtr scene, int body, float[] position, float[] turn, float[] velocity, float[] spin);
        [DllImport(Library)] static extern int carom_touch(IntPtr scene, int a, int b, float[] point, float[] normal, float impulse, float speed, float slip);
        [DllImport(Library)] static extern int carom_frame(IntPtr scene, double seconds);
        [DllImport(Library)] static extern int carom_listen(IntPtr scene, float[] position, float[] right);
        [DllImport(Library)] static extern int carom_govern(IntPtr scene, double share);
        [DllImport(Library)] static extern void carom_report_contacts(IntPtr scene, out Contacts contacts);
        [DllImport(Library)] static extern void carom_close(IntPtr scene);

        // Open the bytes of scene.carom, with its objects there and nothing played.
        public Scene(byte[] baked)
        {
            handle = carom_open(baked, (UIntPtr)baked.Length, 1);
            if (handle == IntPtr.Zero) throw new ArgumentException(Text(carom_answer(IntPtr.Zero)));
        }

        public int Channels { get { return carom_channels(handle); } }
        public double Rate { get { return carom_rate(handle); } }

        // Send a message, as "/object/new crate.2 crate size 1.5 material steel".
        public void Send(string message)
        {
            Expect(carom_send(handle, Bytes(message), -1.0));
        }

        // The number of a body, -1 if there is none of that name.
        public int Body(string name)
        {
            return carom_body(handle, Bytes(name));
        }

        // m; a quaternion w x y z; m/s; rad/s.
        public void Move(int body, float[] position, float[] turn, float[] velocity, float[] spin)
        {
            Expect(carom_move(handle, body, position, turn, velocity, spin));
        }

        // Two bodies touch, with the normal from a to b. NaN: not known.
        public void Touch(int a, int b, float[] point, float[] normal, float impulse = float.NaN, float speed = float.NaN, float slip = float.NaN)
        {
            Expect(carom_touch(handle, a, b, point, normal, impulse, speed, slip));
        }

        // End a frame that was so long (s).
        public void Frame(double seconds)
        {
            Expect(carom_frame(handle, seconds));
        }

        public void Listen(float[] position, float[] right)
        {
            Expect(carom_listen(handle, position, right));
        }

        public void Govern(double share)
        {
            Expect(carom_govern(handle, share));
        }

        // Compute sound: Channels floats for each frame. The one method for another thread.
        public void Process(float[] sound, int frames)
        {
            carom_process(handle, sound, (UIntPtr)frames);
        }

        public Contacts Report()
        {
            Contacts contacts;
            carom_report_contacts(handle, out contacts);
            return contacts;
        }

        public void Dispose()
        {
            if (handle != IntPtr.Zero) carom_close(handle);
            handle = IntPtr.Zero;
        }

        void Expect(int taken)
        {
            if (taken == 0) throw new InvalidOperationException(Text(carom_answer(handle)));
        }

        static byte[] Bytes(string text)
        {
            return System.Text.Encoding.UTF8.GetBytes(text + "\0");
        }

        static string Text(IntPtr text)
        {
            return Marshal.PtrToStringAnsi(text);
        }
    }
}
